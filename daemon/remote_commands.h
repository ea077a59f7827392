// What other programs ask of the mirror, on its way from the bus to the frame loop.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>

namespace cheval::daemon {

/// One wish, as the session understands it.
struct RemoteCommand {
    enum class Kind : std::uint8_t { next, previous, choose, mirrorView, avatarView };
    Kind kind = Kind::next;
    std::size_t outfit = 0;  ///< `choose` only: its number among the wardrobe's outfits.
};

/// A bounded queue in the order of asking, so that "next" after "choose" goes on from what was chosen. Thread-safe; the
/// lock is held for a copy of at most kMaximumWaiting small values, and no call takes heap memory.
class RemoteCommands {
  public:
    static constexpr std::size_t kMaximumWaiting = 32;

    /// False where the loop has not yet taken what waits and there is no more room: nothing is dropped, whoever asks is
    /// told.
    [[nodiscard]] bool push(const RemoteCommand& command) {
        const std::lock_guard lock(mutex_);
        if (count_ == waiting_.size()) return false;
        waiting_[count_++] = command;
        return true;
    }

    /// Moves what waits into `commands`, oldest first, and returns how many.
    std::size_t take(std::span<RemoteCommand, kMaximumWaiting> commands) {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = 0; i < count_; ++i)
            commands[i] = waiting_[i];
        const std::size_t taken = count_;
        count_ = 0;
        return taken;
    }

    /// Forgets what waits: the wardrobe changes, and with it what the numbers mean.
    void clear() {
        const std::lock_guard lock(mutex_);
        count_ = 0;
    }

  private:
    std::mutex mutex_;
    std::array<RemoteCommand, kMaximumWaiting> waiting_{};
    std::size_t count_ = 0;
};

}  // namespace cheval::daemon
