// The display half of the preview: three buffers between the thread that draws and the one that encodes, so that
// neither ever waits for the other.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "hal/display.h"

namespace cheval::hal {

/// A Display whose latest picture another thread takes. Thread-safe; lend() and present() never wait and take no
/// memory.
class PreviewDisplay final : public Display {
  public:
    /// A picture on its way to the viewers.
    struct Picture {
        ImageView<const Rgba8> pixels;
        std::uint64_t number = 0;  ///< Counts presented pictures from 1 since the start, over reopenings.
    };

    explicit PreviewDisplay(const DisplayMode& mode);

    Expected<DisplayMode> open() override;
    void close() override;
    Expected<DisplayBuffer> lend(Duration timeout) override;
    Expected<void> present(const DisplayBuffer& buffer, TimePoint time) override;
    [[nodiscard]] DisplayStatistics statistics() const override;

    /// Number of the picture that was presented last; 0: none yet.
    [[nodiscard]] std::uint64_t lastNumber() const;
    /// Pictures are handed on only while somebody looks.
    void addViewer();
    void removeViewer();
    [[nodiscard]] int viewers() const;

    /// Waits until somebody looks and there is a picture not taken before, and takes the latest; false after stop(). It
    /// stays as it is until giveBack().
    bool take(Picture& picture);
    void giveBack();
    /// Ends take(), now and later.
    void stop();

  private:
    enum class Slot : std::uint8_t { free, lent, ready, taken };

    Slot* find(Slot state);
    [[nodiscard]] std::size_t indexOf(const Slot* slot) const { return static_cast<std::size_t>(slot - slots_.data()); }

    DisplayMode mode_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::array<Image<Rgba8>, 3> pictures_;
    std::array<Slot, 3> slots_{};
    DisplayStatistics statistics_;
    std::uint32_t loan_ = 0;  ///< Number of the latest loan, so that a buffer of an older one is known.
    std::uint64_t lastNumber_ = 0;
    int viewers_ = 0;
    bool open_ = false;
    bool stopped_ = false;
};

}  // namespace cheval::hal
