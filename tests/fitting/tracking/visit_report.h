// The table of what the tracker reaches on the simulated kiosk.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "tests/fitting/tracking/visit_figures.h"

namespace cheval::fitting::test {

/// One line: what was to be reached and what was.
struct ReportRow {
    std::string what, goal, reached;
    std::string count;        ///< Of what it was measured on.
    std::string bounds;       ///< 95 %, where there are any.
    std::optional<bool> met;  ///< None: no goal, for information.
};

std::vector<ReportRow> reportRows(const VisitFigures& figures);
void printReport(const std::vector<ReportRow>& rows, std::FILE* out);
/// Errors by script and joint, jitter and lag by joint.
void printDetails(const VisitFigures& figures, std::FILE* out);
/// The rows as a JSON array of objects of strings and a boolean or null.
std::string jsonOf(const std::vector<ReportRow>& rows);

}  // namespace cheval::fitting::test
