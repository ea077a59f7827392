#include "daemon/instance_lock.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class InstanceLockTest : public testing::Test {
  protected:
    void SetUp() override {
        unsetenv("RUNTIME_DIRECTORY");
        setenv("XDG_RUNTIME_DIR", folder_.path().c_str(), 1);
    }
    void TearDown() override {
        unsetenv("RUNTIME_DIRECTORY");
        unsetenv("XDG_RUNTIME_DIR");
    }

    test::TemporaryFolder folder_;
};

TEST_F(InstanceLockTest, ASecondIsRefusedUntilTheFirstIsGone) {
    Expected<InstanceLock> made = InstanceLock::take();
    ASSERT_TRUE(made) << made.error().message();
    std::optional<InstanceLock> first(std::move(*made));
    EXPECT_TRUE(first->held());
    const Expected<InstanceLock> second = InstanceLock::take();
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::conflict);
    EXPECT_THAT(second.error().message(), AllOf(HasSubstr("process " + std::to_string(getpid())), HasSubstr("Mend: "),
                                                HasSubstr("chevald.lock")));
    first.reset();
    EXPECT_TRUE(InstanceLock::take());
}

TEST_F(InstanceLockTest, AProcessThatIsKilledLeavesNothingBehind) {
    std::array<int, 2> ready{};
    ASSERT_EQ(pipe(ready.data()), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const Expected<InstanceLock> lock = InstanceLock::take();
        const char answer = lock && lock->held() ? 'y' : 'n';
        if (write(ready[1], &answer, 1) == 1) pause();
        _exit(1);
    }
    char answer = 0;
    ASSERT_EQ(read(ready[0], &answer, 1), 1);
    EXPECT_EQ(answer, 'y');
    const Expected<InstanceLock> whileItLives = InstanceLock::take();
    ASSERT_FALSE(whileItLives);
    EXPECT_THAT(whileItLives.error().message(), HasSubstr("process " + std::to_string(child)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    EXPECT_TRUE(InstanceLock::take());
    close(ready[0]);
    close(ready[1]);
}

TEST_F(InstanceLockTest, AServicesFolderComesFirstAndTheFirstOfSeveral) {
    const test::TemporaryFolder service;
    const Expected<InstanceLock> mine = InstanceLock::take();
    ASSERT_TRUE(mine);
    setenv("RUNTIME_DIRECTORY", (service.path().string() + ":/nonexistent").c_str(), 1);
    const Expected<InstanceLock> other = InstanceLock::take();
    ASSERT_TRUE(other) << "another folder is another mirror";
    EXPECT_TRUE(other->held());
    EXPECT_FALSE(InstanceLock::take());
}

TEST_F(InstanceLockTest, WithoutAFolderOrWhereNothingCanBeWrittenItHoldsNothing) {
    setenv("XDG_RUNTIME_DIR", "/nonexistent", 1);
    const Expected<InstanceLock> unwritable = InstanceLock::take();
    ASSERT_TRUE(unwritable);
    EXPECT_FALSE(unwritable->held());
    unsetenv("XDG_RUNTIME_DIR");
    const Expected<InstanceLock> nowhere = InstanceLock::take();
    ASSERT_TRUE(nowhere);
    EXPECT_FALSE(nowhere->held());
}

}  // namespace
}  // namespace cheval::daemon
