#include "fitting/tracking/hand_openness.h"

#include <algorithm>
#include <array>

#include "fitting/tracking/hand_region.h"
#include "fitting/tracking/hand_relief.h"

namespace cheval::fitting::tracking {
namespace {

HandRegionJob regionOf(const HandOpennessJob& job) {
    return {.depth = job.depth,
            .userMap = job.userMap,
            .label = job.label,
            .intrinsics = job.intrinsics,
            .palm = job.palm,
            .elbow = job.elbow,
            .headToNeck = job.headToNeck,
            .close = job.close,
            .mask = &job.context->mask,
            .scratch = &job.context->scratch};
}

float weigh(const HandShape& shape, const HandRelief& relief, float cellMetres, float headToNeck) {
    // One measure's part: its mean and standard deviation over hands of both kinds, and what a deviation weighs.
    struct Measure {
        float value, mean, deviation, weight;
    };
    const float millimetre = 1e-3F / headToNeck;
    const std::array<Measure, 6> measures = {{
        {relief.spread * millimetre, 0.630F, 0.118F, 0.74F},
        {relief.breadth * millimetre, 0.176F, 0.0248F, 0.31F},
        {relief.thickness * millimetre, 0.0779F, 0.0117F, -1.34F},
        {relief.reach * millimetre, 0.734F, 0.156F, 0.64F},
        {shape.fingerReach * cellMetres / headToNeck, 0.734F, 0.202F, 0.47F},
        {static_cast<float>(shape.deepGaps), 2.55F, 1.49F, 1.84F},
    }};
    float logit = 3.58F;
    for (const Measure& measure : measures) {
        logit += measure.weight * (measure.value - measure.mean) / measure.deviation;
    }
    constexpr float kClear = 4.0F;
    return std::clamp(logit / kClear, -1.5F, 1.5F);
}

}  // namespace

bool HandOpennessJob::isValid() const {
    return context != nullptr && regionOf(*this).isValid();
}

void HandOpennessJob::run() {
    found = false;
    HandRegionJob region = regionOf(*this);
    region.run();
    if (region.surface <= 0.0F || region.pixelsPerCell < coarsest) return;
    HandShapeJob outline{.mask = &context->mask, .context = &context->shape, .forearm = region.forearm};
    outline.run();
    HandReliefJob surface{.depth = depth,
                          .intrinsics = intrinsics,
                          .mask = &context->mask,
                          .centre = project(intrinsics, region.palm),
                          .pixelsPerCell = region.pixelsPerCell,
                          .surface = region.surface,
                          .palm = region.palmOnSurface()};
    if (!outline.shape.valid || !surface.isValid()) return;
    surface.run();
    if (!surface.relief.valid) return;
    found = true;
    fingers = outline.shape.fingers;
    openness = weigh(outline.shape, surface.relief, region.cellMetres, headToNeck);
}

}  // namespace cheval::fitting::tracking
