// GPIO lines that a test plays with.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/gpiod/line_provider.h"

namespace cheval::hal::test {

/// What the lines' makers and their users share.
struct FakeChip {
    std::map<std::string, std::deque<LineEdge>> edges;  ///< Waiting, by line.
    std::map<std::string, bool> levels;
    std::map<std::string, std::vector<std::pair<TimePoint, bool>>> driven;  ///< What outputs were set to.
    std::string fault;                                                      ///< Requests fail with this; empty: none.
    std::map<std::string, std::string> faults;                              ///< The same, for one line alone.
    std::size_t room = SIZE_MAX;  ///< Edges of a line that wait; what comes beyond is lost. The kernel has room for 16.
    bool gone = false;            ///< Lines in use fail.
    int requests = 0;
    int held = 0;  ///< Lines in use.

    void edge(const std::string& line, bool active, TimePoint time) {
        if (edges[line].size() < room) edges[line].push_back({.active = active, .time = time});
        levels[line] = active;
    }
};

class FakeLines final : public LineProvider {
  public:
    FakeLines(std::shared_ptr<FakeChip> chip, const Clock& clock) : chip_(std::move(chip)), clock_(clock) {}

    Expected<std::unique_ptr<InputLine>> input(const LineWiring& wiring) override {
        ++chip_->requests;
        if (!chip_->fault.empty())
            return Error{.code = ErrorCode::unavailable, .cause = chip_->fault, .mend = "see gpioinfo"};
        if (const auto fault = chip_->faults.find(wiring.line); fault != chip_->faults.end())
            return Error{.code = ErrorCode::unavailable, .cause = fault->second, .mend = "see gpioinfo"};
        chip_->gone = false;
        return std::unique_ptr<InputLine>(std::make_unique<Input>(chip_, wiring.line));
    }
    Expected<std::unique_ptr<OutputLine>> output(const LineWiring& wiring, bool active) override {
        ++chip_->requests;
        if (!chip_->fault.empty())
            return Error{.code = ErrorCode::unavailable, .cause = chip_->fault, .mend = "see gpioinfo"};
        auto line = std::make_unique<Output>(chip_, wiring.line, clock_);
        static_cast<void>(line->set(active));
        return std::unique_ptr<OutputLine>(std::move(line));
    }

  private:
    static Error lost() { return {.code = ErrorCode::unavailable, .cause = "the chip is gone", .mend = "plug it in"}; }
    class Input final : public InputLine {
      public:
        Input(std::shared_ptr<FakeChip> chip, std::string line) : chip_(std::move(chip)), line_(std::move(line)) {
            ++chip_->held;
            chip_->edges[line_].clear();
        }
        ~Input() override { --chip_->held; }
        Input(const Input&) = delete;
        Input& operator=(const Input&) = delete;
        Expected<std::size_t> read(std::span<LineEdge> edges) override {
            if (chip_->gone) return lost();
            std::deque<LineEdge>& waiting = chip_->edges[line_];
            const std::size_t count = std::min(edges.size(), waiting.size());
            std::copy_n(waiting.begin(), count, edges.begin());
            waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
            return count;
        }
        Expected<bool> active() override {
            if (chip_->gone) return lost();
            return chip_->levels[line_];
        }

      private:
        std::shared_ptr<FakeChip> chip_;
        std::string line_;
    };
    class Output final : public OutputLine {
      public:
        Output(std::shared_ptr<FakeChip> chip, std::string line, const Clock& clock)
            : chip_(std::move(chip)), line_(std::move(line)), clock_(clock) {}
        Expected<void> set(bool active) override {
            if (chip_->gone) return lost();
            chip_->driven[line_].emplace_back(clock_.now(), active);
            return {};
        }

      private:
        std::shared_ptr<FakeChip> chip_;
        std::string line_;
        const Clock& clock_;
    };

    std::shared_ptr<FakeChip> chip_;
    const Clock& clock_;
};

}  // namespace cheval::hal::test
