#include "fitting/tracking/people.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "tests/fitting/tracking/drawn_body.h"

namespace cheval::fitting::tracking {
namespace {

/// A rough surface on the floor, wholly in view, that hides what is behind it. Metres.
Component standing(float width, float height, float depth) {
    Component component;
    component.cells = 4000;
    component.area = 0.6F * width * height;
    component.lower = {-0.5F * width, 0.05F, 2.4F};
    component.upper = {0.5F * width, 0.05F + height, 2.4F + depth};
    component.centroid = 0.5F * (component.lower + component.upper);
    component.topWidth = 0.2F;
    component.topArea = 0.02F;
    component.before = 300;
    component.roughness = 0.05F;
    return component;
}

TEST(LooksLikePerson, AdultsChildrenAndWheelchairUsersDo) {
    EXPECT_TRUE(looksLikePerson(standing(0.5F, 1.75F, 0.3F), true));
    Component spread = standing(1.6F, 1.75F, 0.3F);
    spread.area = 0.7F;
    EXPECT_TRUE(looksLikePerson(spread, true)) << "arms spread";
    EXPECT_TRUE(looksLikePerson(standing(0.3F, 0.85F, 0.2F), true)) << "two years old";
    EXPECT_TRUE(looksLikePerson(standing(0.65F, 1.25F, 0.8F), true)) << "in a wheelchair";
}

TEST(LooksLikePerson, DogsDoNot) {
    EXPECT_FALSE(looksLikePerson(standing(0.95F, 0.70F, 0.25F), true)) << "from the side";
    EXPECT_FALSE(looksLikePerson(standing(0.70F, 0.80F, 0.70F), true)) << "askew";
    Component half = standing(0.45F, 0.90F, 0.25F);
    half.touchesLeft = true;
    EXPECT_FALSE(looksLikePerson(half, true)) << "half in view";
}

TEST(LooksLikePerson, SceneryDoesNot) {
    EXPECT_FALSE(looksLikePerson(standing(2.6F, 1.9F, 0.1F), true)) << "a wall";
    Component hangs = standing(0.5F, 1.0F, 0.2F);
    hangs.lower.y() = 0.6F;
    hangs.upper.y() = 1.6F;
    EXPECT_FALSE(looksLikePerson(hangs, true)) << "clothes on a rail";
    Component flat = standing(0.5F, 1.7F, 0.1F);
    flat.roughness = 0.002F;
    EXPECT_FALSE(looksLikePerson(flat, true)) << "a board";
}

hal::TimePoint at(double seconds) {
    return hal::TimePoint(hal::fromSeconds(seconds));
}

/// The cloud of somebody in the A-pose, or with hanging arms, so far to the side and at such a distance, metres.
Cloud cloudOf(float x, float z, bool armsHang = false) {
    ArticulatedPose pose = test::aPose();
    if (armsHang) pose.arms = {};
    pose.middle.x() = x;
    pose.middle.z() = z;
    return test::DrawnBody(pose).cloud;
}

/// What a sensor sees of both: of each cell the nearer.
Cloud together(const Cloud& one, const Cloud& other) {
    Cloud both = one;
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        if (other.depth[i] <= 0.0F || (one.depth[i] > 0.0F && one.depth[i] < other.depth[i])) continue;
        both.depth[i] = other.depth[i];
        both.x[i] = other.x[i];
        both.y[i] = other.y[i];
        both.z[i] = other.z[i];
    }
    return both;
}

/// The same surface so many cells farther to the sensor's right.
Cloud aside(const Cloud& sound, int cells) {
    Cloud cloud = sound;
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const int column = cellColumn(i) - cells;
        const bool inside = column >= 0 && column < kCloudWidth;
        const std::size_t from = inside ? cellIndex(column, cellRow(i)) : 0;
        cloud.depth[i] = inside ? sound.depth[from] : 0.0F;
        if (cloud.depth[i] <= 0.0F) continue;
        cloud.x[i] = sound.x[from] + static_cast<float>(cells) * sound.cellSize(sound.depth[from]);
        cloud.y[i] = sound.y[from];
        cloud.z[i] = sound.z[from];
    }
    return cloud;
}

/// With the sensor's noise along its axis, a few millimetres.
Cloud noisy(const Cloud& sound, std::mt19937& random) {
    std::normal_distribution<float> noise(0.0F, 0.003F);
    Cloud cloud = sound;
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        if (cloud.depth[i] <= 0.0F) continue;
        const float off = noise(random);
        cloud.depth[i] += off;
        cloud.z[i] += off;
    }
    return cloud;
}

TEST(People, WhoeverStandsStillStaysAndAMannequinDoesNot) {
    std::mt19937 random(3);
    for (const float sway : {0.015F, 0.0F}) {
        const Cloud left = cloudOf(0.0F, 2.4F);
        const Cloud right = cloudOf(sway, 2.4F);
        People people(Zone{});
        for (int frame = 0; frame < 250; ++frame) {
            const Cloud& cloud = (frame / 20) % 2 == 0 ? left : right;
            people.update(noisy(cloud, random), at(0.1 * frame), true);
        }
        EXPECT_EQ(people.users().activeId, sway > 0.0F ? 1U : 0U) << "swaying by " << sway << " m, for 25 seconds";
    }
}

/// Shows people a moving picture, frame by frame.
class Film {
  public:
    explicit Film(double framesPerSecond = 30.0) : period_(1.0 / framesPerSecond) {}
    void show(const Cloud& cloud, int frames = 1) {
        for (int i = 0; i < frames; ++i, time_ += period_)
            people.update(cloud, at(time_), true);
    }
    [[nodiscard]] bool sees(std::uint32_t id) const {
        const Users& users = people.users();
        return std::any_of(users.users.begin(), users.users.begin() + static_cast<std::ptrdiff_t>(users.count),
                           [&](const User& user) { return user.id == id; });
    }
    [[nodiscard]] std::uint32_t active() const { return people.users().activeId; }

    People people{Zone{}};

  private:
    double period_;
    double time_ = 0.0;
};

/// A wall behind all.
Cloud wall() {
    Cloud cloud = test::DrawnBody(test::aPose()).cloud;
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const Eigen::Vector3f along =
            cloud.placement.rotation * unproject(cloud.intrinsics, 2.0F * static_cast<float>(cellColumn(i)) + 0.5F,
                                                 2.0F * static_cast<float>(cellRow(i)) + 0.5F, 1.0F);
        const Eigen::Vector3f point = cloud.placement.translation + 3.6F * along;
        cloud.depth[i] = 3.6F;
        cloud.x[i] = point.x();
        cloud.y[i] = point.y();
        cloud.z[i] = point.z();
    }
    return cloud;
}

TEST(People, KeepTheirIdsWhenAnotherPassesAndCutsThemInTwo) {
    const Cloud shop = wall();
    const Cloud back = cloudOf(0.1F, 2.6F);
    const Cloud stirred = together(shop, aside(back, 2));
    const Cloud front = cloudOf(0.0F, 1.6F);
    for (const int step : {2, 5, -3}) {
        Film film;
        film.show(together(shop, back), 9);
        film.show(stirred, 9);
        ASSERT_EQ(film.people.users().count, 1U);
        const std::uint32_t id = film.people.users().users[0].id;
        ASSERT_EQ(film.active(), id);
        int unseen = 0;
        for (int cells = step > 0 ? -110 : 110; std::abs(cells) <= 110; cells += step) {
            film.show(together(stirred, aside(front, cells)));
            EXPECT_EQ(film.active(), id) << "the other at " << cells;
            EXPECT_LE(film.people.users().count, 2U) << "the other at " << cells;
            if (!film.sees(id)) ++unseen;
        }
        EXPECT_LE(unseen * std::abs(step), 24) << "frames in which nothing was left of the one behind";
        film.show(stirred);
        ASSERT_EQ(film.people.users().count, 1U);
        EXPECT_EQ(film.people.users().users[0].id, id);
    }
}

TEST(People, WaitForWhoeverWasNeverSeenAlone) {
    const Cloud front = cloudOf(0.0F, 1.6F, true);
    const Cloud back = cloudOf(0.0F, 2.6F, true);
    const Cloud shop = wall();
    Film film;
    const auto show = [&](int backCells, int frontCells, int frames) {
        film.show(together(shop, together(aside(back, backCells), aside(front, frontCells))), frames);
    };
    film.show(shop, 10);
    // Both come in side by side; then the nearer steps before the other.
    for (int cells = 160; cells > 50; cells -= 4)
        show(cells - 60, cells, 1);
    ASSERT_EQ(film.people.users().count, 2U);
    const auto& users = film.people.users().users;
    const std::uint32_t id = users[users[0].centroid.z() > users[1].centroid.z() ? 0 : 1].id;
    for (int cells = 50; cells > 0; cells -= 2)
        show(0, cells, 1);
    show(0, 0, 60);
    EXPECT_FALSE(film.sees(id));
    for (int cells = 0; cells > -80; cells -= 4)
        show(0, cells, 1);
    EXPECT_TRUE(film.sees(id)) << "two seconds later, under the old name";
}

TEST(People, WhoeverWalksInBesideSomebodyNearerIsSomebody) {
    const Cloud near = cloudOf(0.0F, 1.6F);
    const Cloud far = cloudOf(0.0F, 2.4F);
    People people(Zone{.nearMetres = 1.9F});
    double time = 0.0;
    // Both walk in side by side, so that neither is ever alone; the nearer is not before the glass.
    for (int cells = 140; cells > 20; cells -= 3, time += 1.0 / 30.0)
        people.update(together(aside(far, cells - 60), aside(near, cells)), at(time), true);
    ASSERT_EQ(people.users().count, 2U);
    ASSERT_NE(people.users().activeId, 0U);
    EXPECT_GT(people.users().active()->centroid.z(), 2.0F);
}

TEST(People, WhoeverSwaysIsSomebodyAtFiveFramesASecondToo) {
    const Cloud left = cloudOf(0.0F, 2.4F);
    const Cloud right = cloudOf(0.02F, 2.4F);
    for (const double rate : {5.0, 30.0}) {
        Film film(rate);
        const int half = static_cast<int>(0.6 * rate);
        int nobody = 0;
        for (int turn = 0; turn < 8; ++turn) {
            for (int i = 0; i < half; ++i) {
                film.show(turn % 2 == 0 ? left : right);
                if (film.active() == 0) ++nobody;
            }
        }
        EXPECT_LE(nobody, 1) << rate;
    }
}

}  // namespace
}  // namespace cheval::fitting::tracking
