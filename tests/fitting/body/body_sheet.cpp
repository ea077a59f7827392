// Draws the body at the middle and the corners of its parameters on one sheet, to be looked at; a report and no test.
// Usage: body_sheet BODY.glb SHEET.png
#include <array>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include "daemon/contact_sheet.h"
#include "fitting/body/body.h"
#include "fitting/body/body_measures.h"
#include "hal/png/png.h"
#include "render/renderer.h"

namespace cheval::fitting {
namespace {

constexpr int kWidth = 260;
constexpr int kHeight = 460;

using Known = std::vector<std::pair<ShapeParameter, float>>;

struct Subject {
    std::string name;
    ShapeParameters parameters;
};

/// What a body is expected to be like that is known to have these dimensions (absolute, metres).
ShapeParameters expected(const Body& body, const MeasuredParameters& mannequin, const Known& known) {
    const auto count = static_cast<Eigen::Index>(known.size());
    Eigen::MatrixXf select = Eigen::MatrixXf::Zero(count, static_cast<Eigen::Index>(kShapeParameterCount));
    Eigen::VectorXf given(count);
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto& [parameter, value] = known[static_cast<std::size_t>(i)];
        const auto k = static_cast<Eigen::Index>(index(parameter));
        select(i, k) = 1.0F;
        given[i] = value - (k < mannequin.size() ? mannequin[k] : 0.0F);
    }
    const Eigen::MatrixXf& covariance = body.shapes.covariance;
    const Eigen::MatrixXf inner = select * covariance * select.transpose();
    return body.shapes.mean + covariance * select.transpose() * inner.ldlt().solve(given - select * body.shapes.mean);
}

std::vector<Subject> subjects(const Body& body, const MeasuredParameters& mannequin) {
    using P = ShapeParameter;
    std::vector<Subject> all;
    all.push_back({"mannequin", ShapeParameters::Zero()});
    all.push_back({"middle", body.shapes.mean});
    const std::vector<std::pair<std::string, Known>> people = {
        {"woman", {{P::masculine, -1.0F}}},
        {"man", {{P::masculine, 1.0F}}},
        {"small slim woman",
         {{P::masculine, -1.0F}, {P::stature, 1.50F}, {P::waistGirth, 0.62F}, {P::hipGirth, 0.84F}}},
        {"tall woman", {{P::masculine, -1.0F}, {P::stature, 1.82F}}},
        {"heavy woman", {{P::masculine, -1.0F}, {P::waistGirth, 1.15F}, {P::hipGirth, 1.28F}}},
        {"slim man", {{P::masculine, 1.0F}, {P::waistGirth, 0.72F}, {P::chestGirth, 0.88F}}},
        {"tall man", {{P::masculine, 1.0F}, {P::stature, 2.00F}}},
        {"heavy man", {{P::masculine, 1.0F}, {P::waistGirth, 1.25F}}},
        {"large adult", {{P::masculine, 1.0F}, {P::stature, 1.98F}, {P::waistGirth, 1.35F}}},
        {"child of six",
         {{P::masculine, 0.0F},
          {P::stature, 1.16F},
          {P::chestGirth, 0.60F},
          {P::waistGirth, 0.55F},
          {P::hipGirth, 0.62F},
          {P::neckGirth, 0.265F},
          {P::shoulderBreadth, 0.235F},
          {P::armLength, 0.355F},
          {P::insideLeg, 0.51F},
          {P::headHeight, 0.205F},
          {P::bust, -0.012F}}},
        {"child of ten",
         {{P::masculine, 0.0F},
          {P::stature, 1.40F},
          {P::chestGirth, 0.70F},
          {P::waistGirth, 0.62F},
          {P::hipGirth, 0.74F},
          {P::neckGirth, 0.29F},
          {P::shoulderBreadth, 0.275F},
          {P::armLength, 0.43F},
          {P::insideLeg, 0.645F},
          {P::headHeight, 0.212F},
          {P::bust, -0.012F}}},
        {"pear", {{P::masculine, -1.0F}, {P::chestGirth, 0.86F}, {P::hipGirth, 1.15F}}},
        {"full bust", {{P::masculine, -1.0F}, {P::bust, 0.05F}}},
        {"athlete", {{P::masculine, 1.0F}, {P::chestGirth, 1.15F}, {P::waistGirth, 0.84F}}},
    };
    for (const auto& [name, known] : people)
        all.push_back({name, expected(body, mannequin, known)});
    for (std::size_t k = 0; k < kShapeParameterCount; ++k) {
        const auto i = static_cast<Eigen::Index>(k);
        for (const float deviations : {-2.0F, 2.0F}) {
            Subject subject{fmt::format("{} {:+.0f} SD", kShapeParameterNames[k], deviations), body.shapes.mean};
            subject.parameters[i] += deviations * std::sqrt(body.shapes.covariance(i, i));
            all.push_back(subject);
        }
    }
    return all;
}

int run(const std::string& bodyPath, const std::string& sheetPath) {
    const auto report = [](const Error& error) {
        std::fprintf(stderr, "body_sheet: %s\n", error.message().c_str());
        return 1;
    };
    Expected<Body> loaded = loadBody(bodyPath);
    if (!loaded) return report(loaded.error());
    const Body& body = *loaded;
    auto renderer = render::Renderer::create({.width = kWidth, .height = kHeight}, std::span(&body.material, 1));
    if (!renderer) return report(renderer.error());
    const BodyMeasures measures(body);
    const MeasuredParameters mannequin = measures.measure(body.mesh.positions, body.joints);

    std::vector<hal::Image<hal::Rgba8>> pictures;
    std::vector<std::string> names;
    std::uint64_t revision = 0;
    for (const Subject& subject : subjects(body, mannequin)) {
        BodyShape shape{.parameters = subject.parameters, .fitted = 1.0F};
        ShapedBody shaped;
        shapeBody(body, shape, shaped);
        const MeasuredParameters measured = measures.measure(shaped.positions, shaped.joints);
        std::printf("%-22s", subject.name.c_str());
        for (Eigen::Index k = 0; k < measured.size(); ++k)
            std::printf(" %6.3f/%+.3f", static_cast<double>(measured[k]),
                        static_cast<double>(measured[k] - mannequin[k] - subject.parameters[k]));
        std::printf("\n");
        for (const float yaw : {0.0F, 1.1F}) {
            // Rest pose faces +Z; who faces the glass looks along −Z.
            const Eigen::Matrix3f turn =
                Eigen::AngleAxisf(3.14159265F + yaw, Eigen::Vector3f::UnitY()).toRotationMatrix();
            const Eigen::Vector3f stand(0.0F, 0.0F, 2.4F);
            PosedMesh mesh;
            for (std::size_t v = 0; v < shaped.positions.size(); ++v) {
                const Eigen::Vector3f p = turn * shaped.positions[v] + stand;
                const Eigen::Vector3f n = turn * shaped.normals[v];
                mesh.vertices.push_back(
                    {p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), body.mesh.uv[v].x(), body.mesh.uv[v].y()});
            }
            for (const Triangle& t : body.mesh.triangles)
                mesh.indices.insert(mesh.indices.end(), {t.a, t.b, t.c});
            mesh.parts = {{.kind = PartKind::body, .indexCount = static_cast<std::uint32_t>(mesh.indices.size())}};
            mesh.topologyRevision = ++revision;
            render::Scene scene{.view = render::View::avatar, .mesh = &mesh};
            scene.hud.screen = render::Screen::wearing;
            scene.skeleton.userId = static_cast<std::uint32_t>(revision);
            for (std::size_t j = 0; j < kJointCount; ++j)
                scene.skeleton.joints[j] = {.position = turn * body.joints[j] + stand, .confidence = 1.0F};
            hal::Image<hal::Rgba8> picture(kWidth, kHeight);
            if (auto drawn = (*renderer)->draw(scene, picture.view()); !drawn) return report(drawn.error());
            pictures.push_back(std::move(picture));
            names.push_back(yaw == 0.0F ? subject.name : fmt::format("{:.2f} m", static_cast<double>(measured[0])));
        }
    }
    std::vector<daemon::SheetPicture> cells;
    for (std::size_t i = 0; i < pictures.size(); ++i)
        cells.push_back({.picture = std::as_const(pictures[i]).view(), .heading = names[i]});
    auto sheet = daemon::drawContactSheet(
        cells, {.title = "The body at the middle and the corners of its parameters",
                .subtitle = "people with known dimensions, then one parameter at a time, all else as in the middle",
                .columns = 16});
    if (!sheet) return report(sheet.error());
    if (auto written = hal::writePng(sheetPath, std::as_const(*sheet).view(), {.compression = 6}); !written)
        return report(written.error());
    return 0;
}

}  // namespace
}  // namespace cheval::fitting

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: body_sheet BODY.glb SHEET.png\n");
        return 2;
    }
    try {
        return cheval::fitting::run(argv[1], argv[2]);
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "body_sheet: %s\n", exception.what());
        return 1;
    }
}
