#include "hal/png/png.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#include <fcntl.h>
#include <spng.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cheval::hal {

namespace {

struct ContextDeleter {
    void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, ContextDeleter>;

struct MallocDeleter {
    void operator()(void* memory) const { std::free(memory); }
};

Error outOfMemory() {
    return {.code = ErrorCode::resource, .cause = "there is no memory left for a picture"};
}

Error refused(int code) {
    return {.code = ErrorCode::invalidInput,
            .cause = std::string("the PNG cannot be decoded: ") + spng_strerror(code),
            .mend = "write the picture again",
            .why = "it is truncated, damaged or no PNG"};
}

int channelsOf(int colourType) {
    switch (colourType) {
        case SPNG_COLOR_TYPE_TRUECOLOR:
            return 3;
        case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
            return 2;
        case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
            return 4;
        default:
            return 1;
    }
}

// A decoder that has read the header and found it worth decoding.
struct Decoder {
    Context context;
    PngInfo info;
};

Expected<Decoder> beginDecoding(std::span<const std::byte> png, const PngLimits& limits) {
    Decoder decoder{.context = Context(spng_ctx_new(0)), .info = {}};
    spng_ctx* context = decoder.context.get();
    if (context == nullptr) return outOfMemory();
    if (png.size() > limits.maxFileBytes) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the PNG has " + std::to_string(png.size()) + " bytes",
                     .mend = "use a smaller picture",
                     .why = "at most " + std::to_string(limits.maxFileBytes) + " are read"};
    }
    spng_set_image_limits(context, static_cast<std::uint32_t>(limits.maxWidth),
                          static_cast<std::uint32_t>(limits.maxHeight));
    // The second figure bounds all such chunks together.
    spng_set_chunk_limits(context, limits.maxChunkBytes, 2 * limits.maxChunkBytes);
    if (const int code = spng_set_png_buffer(context, png.data(), png.size())) return refused(code);
    spng_ihdr header{};
    const int code = spng_get_ihdr(context, &header);
    if (code == SPNG_EUSER_WIDTH || code == SPNG_EUSER_HEIGHT) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the picture is too large",
                     .mend = "use a smaller picture",
                     .why = "at most " + std::to_string(limits.maxWidth) + " by " + std::to_string(limits.maxHeight) +
                            " pixels are read"};
    }
    if (code != 0) return refused(code);
    decoder.info = {.width = static_cast<int>(header.width),
                    .height = static_cast<int>(header.height),
                    .bitDepth = header.bit_depth,
                    .colourType = header.color_type};
    const std::size_t pixels = std::size_t{header.width} * header.height;
    if (pixels > limits.maxPixels) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the picture has " + std::to_string(header.width) + " by " +
                              std::to_string(header.height) + " pixels",
                     .mend = "use a smaller picture",
                     .why = "at most " + std::to_string(limits.maxPixels) + " pixels are read"};
    }
    // Deflate makes at most 1032 bytes of one, so a short file that claims many pixels is refused before they are
    // allocated.
    constexpr std::size_t kDeflateRatio = 1032;
    const std::size_t bits = pixels * header.bit_depth * static_cast<std::size_t>(channelsOf(header.color_type));
    if (bits / 8 / kDeflateRatio > png.size()) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the picture claims " + std::to_string(header.width) + " by " +
                              std::to_string(header.height) + " pixels",
                     .mend = "write the picture again",
                     .why = "a file of " + std::to_string(png.size()) + " bytes cannot hold so many"};
    }
    return decoder;
}

template <typename Pixel>
Expected<void> decodeInto(Decoder& decoder, Image<Pixel>& to, int format, int flags) {
    to.width = decoder.info.width;
    to.height = decoder.info.height;
    to.pixels.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height));
    const std::size_t bytes = to.pixels.size() * sizeof(Pixel);
    std::size_t needed = 0;
    if (const int code = spng_decoded_image_size(decoder.context.get(), format, &needed)) return refused(code);
    if (needed != bytes) return Error{.code = ErrorCode::internal, .cause = "a picture's size was reckoned wrongly"};
    if (const int code = spng_decode_image(decoder.context.get(), to.pixels.data(), bytes, format, flags)) {
        return refused(code);
    }
    // The pixels may be complete before the file is: a picture that was cut off is refused even so.
    if (const int code = spng_decode_chunks(decoder.context.get())) return refused(code);
    return {};
}

template <typename Pixel>
Expected<void> decodeColour(std::span<const std::byte> png, Image<Pixel>& to, const PngLimits& limits, int format) {
    Expected<Decoder> decoder = beginDecoding(png, limits);
    if (!decoder) return std::move(decoder).error();
    return decodeInto(*decoder, to, format, SPNG_DECODE_TRNS);
}

template <typename Pixel>
Expected<void> encode(ImageView<const Pixel> picture, std::vector<std::byte>& png, const PngWriteOptions& options,
                      int colourType) {
    if (picture.empty()) {
        return Error{.code = ErrorCode::invalidInput, .cause = "a picture without pixels cannot be written as PNG"};
    }
    const Context context(spng_ctx_new(SPNG_CTX_ENCODER));
    if (context == nullptr) return outOfMemory();
    spng_ihdr header{.width = static_cast<std::uint32_t>(picture.width),
                     .height = static_cast<std::uint32_t>(picture.height),
                     .bit_depth = sizeof(Pixel) == 2 ? std::uint8_t{16} : std::uint8_t{8},
                     .color_type = static_cast<std::uint8_t>(colourType),
                     .compression_method = 0,
                     .filter_method = 0,
                     .interlace_method = SPNG_INTERLACE_NONE};
    int code = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
    if (code == 0) code = spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, options.compression);
    if (code == 0 && options.oneFilter)
        code = spng_set_option(context.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
    if (code == 0) code = spng_set_ihdr(context.get(), &header);
    if (code == 0)
        code =
            spng_encode_image(context.get(), nullptr, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
    for (int y = 0; code == 0 && y < picture.height; ++y) {
        code = spng_encode_row(context.get(), picture.row(y), static_cast<std::size_t>(picture.width) * sizeof(Pixel));
    }
    if (code != SPNG_EOI && code != 0) {
        return Error{.code = code == SPNG_EMEM ? ErrorCode::resource : ErrorCode::invalidInput,
                     .cause = std::string("the picture cannot be written as PNG: ") + spng_strerror(code)};
    }
    std::size_t size = 0;
    const std::unique_ptr<void, MallocDeleter> buffer(spng_get_png_buffer(context.get(), &size, &code));
    if (buffer == nullptr) return outOfMemory();
    const auto* bytes = static_cast<const std::byte*>(buffer.get());
    png.assign(bytes, bytes + size);
    return {};
}

template <typename Pixel>
Expected<void> read(const std::string& path, Image<Pixel>& to, const PngLimits& limits) {
    std::vector<std::byte> bytes;
    if (auto done = readBytes(path, limits.maxFileBytes, bytes); !done) return done;
    auto decoded = decodePng(bytes, to, limits);
    if (!decoded) decoded.error().file = path;
    return decoded;
}

template <typename Pixel>
Expected<void> write(const std::string& path, ImageView<const Pixel> picture, const PngWriteOptions& options) {
    std::vector<std::byte> bytes;
    auto done = encodePng(picture, bytes, options);
    if (done) return writeBytes(path, bytes);
    done.error().file = path;
    return done;
}

class Descriptor {
  public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int get() const { return number_; }
    int release() { return std::exchange(number_, -1); }

  private:
    int number_;
};

Error systemError(std::string_view what, const std::string& path) {
    const int number = errno;
    return {.code = number == ENOENT || number == ENOTDIR ? ErrorCode::notFound : ErrorCode::resource,
            .cause = std::string(what) + ": " + std::strerror(number),
            .mend = number == EACCES   ? "let this user reach the file"
                    : number == ENOSPC ? "free some disk space"
                                       : "check the path",
            .why = {},
            .file = path};
}

}  // namespace

Expected<PngInfo> inspectPng(std::span<const std::byte> png, const PngLimits& limits) {
    Expected<Decoder> decoder = beginDecoding(png, limits);
    if (!decoder) return std::move(decoder).error();
    return decoder->info;
}

Expected<void> decodePng(std::span<const std::byte> png, Image<std::uint16_t>& to, const PngLimits& limits) {
    Expected<Decoder> decoder = beginDecoding(png, limits);
    if (!decoder) return std::move(decoder).error();
    if (!decoder->info.isGrey16()) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the picture has " + std::to_string(channelsOf(decoder->info.colourType)) +
                              " channel(s) of " + std::to_string(decoder->info.bitDepth) + " bits",
                     .mend = "write depth as 16-bit grey PNG",
                     .why = "fewer bits cannot hold millimetres, and colours are not depth"};
    }
    return decodeInto(*decoder, to, SPNG_FMT_PNG, 0);
}

Expected<void> decodePng(std::span<const std::byte> png, Image<Rgb8>& to, const PngLimits& limits) {
    static_assert(sizeof(Rgb8) == 3);
    return decodeColour(png, to, limits, SPNG_FMT_RGB8);
}

Expected<void> decodePng(std::span<const std::byte> png, Image<Rgba8>& to, const PngLimits& limits) {
    static_assert(sizeof(Rgba8) == 4);
    return decodeColour(png, to, limits, SPNG_FMT_RGBA8);
}

Expected<void> encodePng(ImageView<const std::uint16_t> picture, std::vector<std::byte>& png,
                         const PngWriteOptions& options) {
    return encode(picture, png, options, SPNG_COLOR_TYPE_GRAYSCALE);
}

Expected<void> encodePng(ImageView<const Rgb8> picture, std::vector<std::byte>& png, const PngWriteOptions& options) {
    return encode(picture, png, options, SPNG_COLOR_TYPE_TRUECOLOR);
}

Expected<void> encodePng(ImageView<const Rgba8> picture, std::vector<std::byte>& png, const PngWriteOptions& options) {
    return encode(picture, png, options, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA);
}

Expected<void> readBytes(const std::string& path, std::size_t maxBytes, std::vector<std::byte>& bytes) {
    // Without O_NONBLOCK, opening a named pipe would wait for a writer.
    const Descriptor file(
        ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // NOLINT(cppcoreguidelines-pro-type-vararg)
    if (file.get() < 0) return systemError("the file cannot be opened", path);
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) return systemError("the file cannot be examined", path);
    if (!S_ISREG(status.st_mode)) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "this is not a plain file",
                     .mend = "check the path",
                     .why = {},
                     .file = path};
    }
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size > maxBytes) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the file has " + std::to_string(size) + " bytes",
                     .mend = "use a smaller file",
                     .why = "at most " + std::to_string(maxBytes) + " are read",
                     .file = path};
    }
    bytes.resize(size);
    std::size_t done = 0;
    while (done < size) {
        const ssize_t got = ::read(file.get(), bytes.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return systemError("the file cannot be read", path);
        if (got == 0) break;  // It shrank meanwhile: what is left is judged by whoever parses it.
        done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return {};
}

Expected<void> writeBytes(const std::string& path, std::span<const std::byte> bytes) {
    Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC,
                           0644));  // NOLINT(cppcoreguidelines-pro-type-vararg)
    if (file.get() < 0) return systemError("the file cannot be created", path);
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t put = ::write(file.get(), bytes.data() + done, bytes.size() - done);
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) return systemError("the file cannot be written", path);
        done += static_cast<std::size_t>(put);
    }
    if (::close(file.release()) != 0) return systemError("the file cannot be written", path);
    return {};
}

Expected<PngInfo> inspectPngFile(const std::string& path, const PngLimits& limits) {
    std::vector<std::byte> bytes;
    if (auto done = readBytes(path, limits.maxFileBytes, bytes); !done) return std::move(done).error();
    auto info = inspectPng(bytes, limits);
    if (!info) info.error().file = path;
    return info;
}

Expected<void> readPng(const std::string& path, Image<std::uint16_t>& to, const PngLimits& limits) {
    return read(path, to, limits);
}
Expected<void> readPng(const std::string& path, Image<Rgb8>& to, const PngLimits& limits) {
    return read(path, to, limits);
}
Expected<void> readPng(const std::string& path, Image<Rgba8>& to, const PngLimits& limits) {
    return read(path, to, limits);
}

Expected<void> writePng(const std::string& path, ImageView<const std::uint16_t> picture,
                        const PngWriteOptions& options) {
    return write(path, picture, options);
}
Expected<void> writePng(const std::string& path, ImageView<const Rgb8> picture, const PngWriteOptions& options) {
    return write(path, picture, options);
}
Expected<void> writePng(const std::string& path, ImageView<const Rgba8> picture, const PngWriteOptions& options) {
    return write(path, picture, options);
}

}  // namespace cheval::hal
