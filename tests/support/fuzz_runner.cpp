// Runs a fuzz harness without libFuzzer: seeds, truncations and mutations that are the same on every run, so that every
// compiler's test run exercises the refusals; or the files named on the command line.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/support/fuzz.h"

namespace {

using cheval::test::FuzzInput;

#ifndef CHEVAL_FUZZ_MUTATIONS
#define CHEVAL_FUZZ_MUTATIONS 400
#endif
#ifndef CHEVAL_FUZZ_UNIT
#define CHEVAL_FUZZ_UNIT 1
#endif
constexpr int kMutationsPerSeed = CHEVAL_FUZZ_MUTATIONS;
constexpr std::size_t kUnit = CHEVAL_FUZZ_UNIT;  ///< Bytes.
constexpr std::size_t kMaxTruncations = 400;

std::size_t below(std::mt19937& random, std::size_t bound) {
    return bound == 0 ? 0 : random() % bound;
}

void mutate(FuzzInput& input, const FuzzInput& other, std::mt19937& random) {
    static constexpr std::uint8_t kTelling[] = {0x00, 0x01, 0x7F, 0x80, 0xFF, '"', '{', '}', '-', '9'};
    for (std::size_t left = 1 + below(random, 6); left > 0; --left) {
        const std::size_t at = below(random, input.size());
        switch (random() % 6) {
            case 0:
                if (!input.empty()) input[at] ^= static_cast<std::uint8_t>(1U << (random() % 8));
                break;
            case 1:
                if (!input.empty()) input[at] = kTelling[random() % std::size(kTelling)];
                break;
            case 2: {  // A 32-bit length or count, of either byte order.
                const auto value = static_cast<std::uint8_t>(random());
                for (std::size_t i = at; i < std::min(at + 4, input.size()); ++i)
                    input[i] = value;
                break;
            }
            case 3: {
                const std::size_t length = std::min(below(random, 32), input.size() - at);
                input.erase(input.begin() + static_cast<std::ptrdiff_t>(at),
                            input.begin() + static_cast<std::ptrdiff_t>(at + length));
                break;
            }
            case 4: {
                const FuzzInput copy(input.begin() + static_cast<std::ptrdiff_t>(at),
                                     input.begin() + static_cast<std::ptrdiff_t>(std::min(at + 16, input.size())));
                input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), copy.begin(), copy.end());
                break;
            }
            default: {
                const std::size_t from = std::min(at, other.size());
                input.resize(at);
                input.insert(input.end(), other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
                break;
            }
        }
    }
}

void run(const FuzzInput& input) {
    // An exact copy on the heap, so that the address sanitizer sees a read past the end. Never null: the standard
    // library forbids null even for nothing.
    FuzzInput exact;
    exact.reserve(std::max<std::size_t>(input.size(), 1));
    exact = input;
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

int runFiles(int count, char** paths) {
    for (int i = 0; i < count; ++i) {
        std::ifstream file(paths[i], std::ios::binary);
        if (!file) {
            std::fprintf(stderr, "%s cannot be read\n", paths[i]);
            return 1;
        }
        run(FuzzInput(std::istreambuf_iterator<char>(file), {}));
        std::printf("%s: passed\n", paths[i]);
    }
    return 0;
}

int writeSeeds(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const auto seeds = cheval::test::fuzzSeeds();
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        std::ofstream file(folder / ("seed-" + std::to_string(i)), std::ios::binary);
        file.write(reinterpret_cast<const char*>(seeds[i].data()), static_cast<std::streamsize>(seeds[i].size()));
        if (!file.flush()) return 1;
    }
    return 0;
}

int runSeeds() {
    const auto seeds = cheval::test::fuzzSeeds();
    if (seeds.empty()) {
        std::fputs("the harness has no seeds\n", stderr);
        return 1;
    }
    std::mt19937 random(
        1);  // NOLINT(cert-msc32-c,cert-msc51-cpp,bugprone-random-generator-seed): the same on every run.
    std::size_t inputs = 0;
    run({});
    for (const FuzzInput& seed : seeds) {
        run(seed);
        const std::size_t step = std::max(kUnit, seed.size() / kMaxTruncations);
        for (std::size_t length = 0; length < seed.size(); length += step, ++inputs) {
            run(FuzzInput(seed.begin(), seed.begin() + static_cast<std::ptrdiff_t>(length)));
        }
        for (int i = 0; i < kMutationsPerSeed; ++i, ++inputs) {
            FuzzInput input = seed;
            mutate(input, seeds[below(random, seeds.size())], random);
            run(input);
        }
    }
    std::printf("%zu seeds and %zu inputs made of them: passed\n", seeds.size(), inputs);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc == 3 && std::string(argv[1]) == "--write-seeds") return writeSeeds(argv[2]);
    return argc > 1 ? runFiles(argc - 1, argv + 1) : runSeeds();
}
