// Who is who: components become users with IDs, one of whom is being dressed.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "fitting/tracking/background.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/components.h"
#include "fitting/users.h"
#include "hal/clock.h"

namespace cheval::fitting::tracking {

/// Where a person is dressed: metres from the glass, and to either side of the display's centre.
struct Zone {
    float nearMetres = 0.5F;
    float farMetres = 4.5F;
    float halfWidthMetres = 1.5F;

    /// Whether a place is in it, or no farther beyond it than `margin` metres.
    [[nodiscard]] bool contains(const Eigen::Vector3f& mirror, float margin = 0.0F) const {
        return mirror.z() >= nearMetres - margin && mirror.z() <= farMetres + margin &&
               std::abs(mirror.x()) <= halfWidthMetres + margin;
    }
};

/// True for a component that may be a person: by area, height, and a top as narrow as a head or hands rather than a
/// shelf's, and, where the floor is known, by standing on it or being cut by the picture's lower edge (clothes on a
/// rail hang). Children and people in wheelchairs included.
bool looksLikePerson(const Component& component, bool floorKnown);
/// True for what is too low for its length to stand on two legs, or may be once it is wholly in view. The floor known.
bool looksLikeAnimal(const Component& component);
/// True for what can only be a wall, a rack or furniture.
bool looksLikeScenery(const Component& component);

/// Finds the people of each frame. Owns the background. Thread-bound; takes no memory after construction.
class People {
  public:
    explicit People(const Zone& zone);
    void reset();

    /// Reads a cloud; `time` is its capture time. Where the floor is known, what lies on it is left out.
    void update(const Cloud& cloud, hal::TimePoint time, bool floorKnown);
    /// Nothing could be seen in a frame at `time`: nobody is present, and time passes for those who were.
    void seeNothing(hal::TimePoint time);

    /// Without the map, which the tracker makes at full size.
    [[nodiscard]] const Users& users() const { return users_; }
    /// One label a cell, kCloudCells; User::label or 0.
    [[nodiscard]] std::span<const std::uint8_t> labels() const { return labels_; }

    /// An active user not seen for this long has left; others may then become active.
    static constexpr double kDwellSeconds = 1.0;
    /// Somebody before whom another person stands may be there still, for this long.
    static constexpr double kHiddenSeconds = 5.0;

  private:
    struct Person {
        std::uint32_t id = 0;
        Eigen::Vector3f centroid = Eigen::Vector3f::Zero();
        Eigen::Vector3f velocity = Eigen::Vector3f::Zero();    ///< Metres a second.
        Eigen::Vector3f measuredAt = Eigen::Vector3f::Zero();  ///< Where the centroid was last measured,
        hal::TimePoint measured{};                             ///< … and when.
        Eigen::Vector3f birthplace = Eigen::Vector3f::Zero();
        Eigen::Vector3f restingPlace = Eigen::Vector3f::Zero();  ///< Where the centroid last came to rest.
        hal::TimePoint lastSeen{};
        hal::TimePoint lastMoved{};                        ///< When it last left its resting place.
        bool walked = false;                               ///< Left its birthplace at some time: no shop mannequin.
        Eigen::Vector3f spread = Eigen::Vector3f::Zero();  ///< Of its surface about the centroid: deviations, metres.
        /// Both as first seen with nobody near, and of late; the centroid in the sensor frame, in metres.
        Eigen::Vector3f firstCentroid = Eigen::Vector3f::Zero(), firstSpread = Eigen::Vector3f::Zero();
        Eigen::Vector3f meanCentroid = Eigen::Vector3f::Zero(), meanSpread = Eigen::Vector3f::Zero();  ///< Of late.
        float tallest = 0.0F;          ///< The highest that was ever seen of it.
        int lowFrames = 0;             ///< In a row that showed something low and long.
        float settled = 0.0F;          ///< Seconds in a row with nobody near.
        bool alive = false;            ///< They have changed since.
        bool wasThere = false;         ///< In the first frame of all.
        float watched = 0.0F;          ///< Seconds of moving pictures in which it could have stirred.
        bool seen = false;             ///< In this frame.
        hal::TimePoint hiddenSince{};  ///< When somebody began to stand before them, while unseen.
        bool hidden = false;
        /// Around all of them, as last seen with nobody before them or beside them; until then, as first seen.
        Eigen::AlignedBox3f whole;
        User user;
    };

    /// A cell that was a person's in the frame before, and shows the same surface still.
    [[nodiscard]] bool wasSame(const Cloud& cloud, std::size_t cell) const {
        constexpr float kStep = 0.20F;
        return previousLabels_[cell] != 0 && std::abs(cloud.depth[cell] - previousDepth_[cell]) < kStep;
    }
    void findForeground(const Cloud& cloud, bool floorKnown);
    void assignComponents(const Cloud& cloud);
    /// How much of the breadth of a box another person before it covers, as the sensor sees it; negative: how far
    /// beside.
    static float coveredShare(const Person& front, const Eigen::AlignedBox3f& back);
    /// The most that any of those who are seen covers of a person's box, see coveredShare(); −1 where nobody stands
    /// before them.
    [[nodiscard]] float covered(const Person& person, const Eigen::AlignedBox3f& box) const;
    void rememberWhole();
    void findTheLiving(const Cloud& cloud, float elapsed);
    void findTheHidden(hal::TimePoint time);
    /// Takes walls and racks away from those of whom a whole person is seen beside them.
    void dropScenery(bool floorKnown);
    /// Gives to those whom others cut in two the pieces that nobody has.
    void rejoinPieces();
    void adopt(std::size_t component, hal::TimePoint time);
    void attachFragments();
    void labelCells(const Cloud& cloud);
    void measurePeople(const Cloud& cloud, hal::TimePoint time, bool floorKnown);
    void judgeCells(const Cloud& cloud);
    void forgetTheGone(hal::TimePoint time);
    void chooseActive(hal::TimePoint time);

    Zone zone_;
    Background background_;
    std::vector<std::uint8_t> mask_, componentLabels_, labels_, previousLabels_;
    std::vector<float> previousDepth_;
    std::vector<Belief> belief_;
    std::vector<std::uint32_t> scratch_;
    std::vector<Component> components_;
    std::size_t componentCount_ = 0;
    std::array<std::uint8_t, kMaximumComponents + 1> owner_{};  ///< Person index + 1 of each component; 0: nobody's.
    std::array<bool, kMaximumComponents + 1> shared_{};         ///< Overlaps two people: its cells are divided.
    std::array<Person, kMaximumUsers> people_{};
    std::uint32_t nextId_ = 1;
    std::uint32_t activeId_ = 0;
    hal::TimePoint lastTime_{};
    bool started_ = false, first_ = false;
    Users users_;
};

}  // namespace cheval::fitting::tracking
