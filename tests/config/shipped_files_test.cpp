#include "config/shipped_files.h"

#include <filesystem>

#include <gtest/gtest.h>

namespace cheval::config {
namespace {

TEST(ShippedFiles, areFoundFromTheProgramsOwnFolder) {
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
    const std::filesystem::path folder = program.parent_path();
    EXPECT_EQ(shippedPath((folder.filename() / program.filename()).string()), program.string());
    EXPECT_EQ(shippedPath(folder.filename().string()), folder.string());
}

TEST(ShippedFiles, areNoneInABuildTree) {
    EXPECT_EQ(shippedPath("lib/cheval/cheval.toml"), "");
}

}  // namespace
}  // namespace cheval::config
