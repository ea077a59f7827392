// What many measured visits come to.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tests/fitting/body/measured_visit.h"
#include "tests/fitting/tracking/visit_statistics.h"

namespace cheval::fitting::test {

/// A moment of the visit at which a measurement is looked at.
enum class Moment : std::uint8_t { half, one, two, three, five, sides, end };
inline constexpr std::size_t kMomentCount = 7;
inline constexpr std::array<const char*, kMomentCount> kMomentNames = {"0.5", "1", "2", "3", "5", "sides", "end"};

/// The measurements at that moment, if the visit came so far.
const Measurements* at(const MeasuredVisit& visit, Moment moment);

/// Errors of one dimension, metres: measured less true, of visits in which it was told.
struct DimensionErrors {
    std::vector<double> errors;
    Rate told;     ///< Of the visits that came to the moment.
    Rate covered;  ///< Truths within 1.96 standard uncertainties, of those told.

    void add(const Measurement& measured, double truth);
    [[nodiscard]] double meanAbsolute() const;
    [[nodiscard]] double bias() const;
    [[nodiscard]] double deviation() const;  ///< About the bias; 0 of fewer than two.
    [[nodiscard]] double absoluteQuantile(double share) const;
};

struct MeasuredFigures {
    std::array<std::array<DimensionErrors, kDimensionCount>, kMomentCount> errors;
    std::vector<double> converged;       ///< Seconds of facing, of visits that converged …
    Rate converging;                     ///< … among all that faced the glass.
    std::map<std::string, long> doubts;  ///< At the end, by name.
    long notFaced = 0;
};
/// Whatever is told counts; with `sure`, only what is told without a doubt.
MeasuredFigures figuresOf(std::span<const MeasuredVisit> visits, bool sure);

/// Both in words for people and for programs.
std::string tableOf(const MeasuredFigures& figures);
std::string jsonOf(std::span<const MeasuredVisit> visits);

}  // namespace cheval::fitting::test
