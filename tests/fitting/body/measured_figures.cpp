#include "tests/fitting/body/measured_figures.h"

#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cheval::fitting::test {

namespace {

constexpr std::array<double, kMomentCount> kFacingSeconds = {0.5, 1.0, 2.0, 3.0, 5.0, 0.0, 0.0};

std::string millimetres(double metres) {
    return fmt::format("{:.1f}", 1000.0 * metres);
}

nlohmann::json jsonOf(const Measurements& measured) {
    nlohmann::json values = nlohmann::json::object();
    for (std::size_t i = 0; i < kDimensionCount; ++i) {
        const Measurement& one = measured.dimensions[i];
        if (!one.valid) continue;
        values[std::string(kDimensionNames[i])] = {std::round(1e5 * static_cast<double>(one.value)) / 1e5,
                                                   std::round(1e5 * static_cast<double>(one.uncertainty)) / 1e5};
    }
    return {{"doubt", nameOf(measured.doubt)}, {"converged", measured.converged}, {"values", std::move(values)}};
}

}  // namespace

const Measurements* at(const MeasuredVisit& visit, Moment moment) {
    if (!visit.faced) return nullptr;
    if (moment == Moment::end) return &visit.end;
    if (moment == Moment::sides) return visit.sides ? &*visit.sides : nullptr;
    const auto reading =
        static_cast<std::size_t>(std::lround(kFacingSeconds[static_cast<std::size_t>(moment)] / kReadingSeconds) - 1);
    return reading < visit.facingCount ? &visit.facing[reading] : nullptr;
}

void DimensionErrors::add(const Measurement& measured, double truth) {
    told.add(measured.valid);
    if (!measured.valid) return;
    const double error = static_cast<double>(measured.value) - truth;
    errors.push_back(error);
    covered.add(std::abs(error) <= kNormal95 * static_cast<double>(measured.uncertainty));
}

double DimensionErrors::meanAbsolute() const {
    const double sum = std::accumulate(errors.begin(), errors.end(), 0.0,
                                       [](double all, double error) { return all + std::abs(error); });
    return errors.empty() ? 0.0 : sum / static_cast<double>(errors.size());
}

double DimensionErrors::bias() const {
    const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
    return errors.empty() ? 0.0 : sum / static_cast<double>(errors.size());
}

double DimensionErrors::deviation() const {
    if (errors.size() < 2) return 0.0;
    const double middle = bias();
    const double sum = std::accumulate(errors.begin(), errors.end(), 0.0, [middle](double all, double error) {
        return all + (error - middle) * (error - middle);
    });
    return std::sqrt(sum / static_cast<double>(errors.size() - 1));
}

double DimensionErrors::absoluteQuantile(double share) const {
    std::vector<double> absolute(errors.size());
    for (std::size_t i = 0; i < errors.size(); ++i)
        absolute[i] = std::abs(errors[i]);
    return quantile(std::move(absolute), share);
}

MeasuredFigures figuresOf(std::span<const MeasuredVisit> visits, bool sure) {
    MeasuredFigures figures;
    for (const MeasuredVisit& visit : visits) {
        if (!visit.faced) {
            ++figures.notFaced;
            continue;
        }
        figures.converging.add(visit.converged.has_value());
        if (visit.converged) figures.converged.push_back(*visit.converged);
        ++figures.doubts[nameOf(visit.end.doubt)];
        for (std::size_t moment = 0; moment < kMomentCount; ++moment) {
            const Measurements* measured = at(visit, static_cast<Moment>(moment));
            if (measured == nullptr) continue;
            if (sure && measured->doubt != MeasurementDoubt::none) continue;
            for (std::size_t i = 0; i < kDimensionCount; ++i)
                figures.errors[moment][i].add(measured->dimensions[i], static_cast<double>(visit.truth[i]));
        }
    }
    return figures;
}

std::string tableOf(const MeasuredFigures& figures) {
    std::string text = fmt::format("{:<17}{:<7}{:>9}{:>9}{:>9}{:>9}{:>9}{:>15}{:>12}\n", "dimension", "at", "told",
                                   "MAE mm", "bias mm", "SD mm", "p90 mm", "within 1.96 u", "95 % bounds");
    for (std::size_t i = 0; i < kDimensionCount; ++i) {
        for (std::size_t moment = 0; moment < kMomentCount; ++moment) {
            const DimensionErrors& one = figures.errors[moment][i];
            text += fmt::format("{:<17}{:<7}{:>9}", moment == 0 ? kDimensionNames[i] : "", kMomentNames[moment],
                                fmt::format("{}/{}", one.told.hits, one.told.count));
            if (one.errors.empty()) {
                text += fmt::format("{:>9}\n", "-");
                continue;
            }
            const auto [low, high] = one.covered.bounds();
            text += fmt::format("{:>9}{:>9}{:>9}{:>9}{:>13.1f} %{:>8.0f}-{:.0f} %\n", millimetres(one.meanAbsolute()),
                                millimetres(one.bias()), millimetres(one.deviation()),
                                millimetres(one.absoluteQuantile(0.9)), 100.0 * one.covered.share(), 100.0 * low,
                                100.0 * high);
        }
    }
    text += fmt::format("\nconverged: {} of {} visits, after {:.2f} s of facing (median), {:.2f} s (95 %)\n",
                        figures.converging.hits, figures.converging.count, quantile(figures.converged, 0.5),
                        quantile(figures.converged, 0.95));
    text += "doubt at the end:";
    for (const auto& [doubt, count] : figures.doubts)
        text += fmt::format(" {} {}", doubt, count);
    if (figures.notFaced > 0) text += fmt::format("\n{} never stood facing the glass", figures.notFaced);
    return text + "\n";
}

std::string jsonOf(std::span<const MeasuredVisit> visits) {
    nlohmann::json all = nlohmann::json::array();
    for (const MeasuredVisit& visit : visits) {
        nlohmann::json truth = nlohmann::json::object();
        for (std::size_t i = 0; i < kDimensionCount; ++i)
            truth[std::string(kDimensionNames[i])] = visit.truth[i];
        nlohmann::json one = {{"seed", visit.options.seed},
                              {"clothing", nameOf(visit.options.clothing)},
                              {"noise", visit.options.noiseScale},
                              {"child", visit.child},
                              {"wheelchair", visit.wheelchair},
                              {"frames", visit.frames},
                              {"tracked_frames", visit.trackedFrames},
                              {"truth", std::move(truth)},
                              {"converged", nullptr},
                              {"moments", nlohmann::json::object()},
                              {"facing", nlohmann::json::array()}};
        if (visit.converged) one["converged"] = *visit.converged;
        for (std::size_t moment = 0; moment < kMomentCount; ++moment) {
            if (const Measurements* measured = at(visit, static_cast<Moment>(moment)))
                one["moments"][kMomentNames[moment]] = jsonOf(*measured);
        }
        for (std::size_t i = 0; i < visit.facingCount; ++i) {
            nlohmann::json reading = jsonOf(visit.facing[i]);
            reading["seconds"] = kReadingSeconds * static_cast<double>(i + 1);
            one["facing"].push_back(std::move(reading));
        }
        all.push_back(std::move(one));
    }
    return all.dump() + "\n";
}

}  // namespace cheval::fitting::test
