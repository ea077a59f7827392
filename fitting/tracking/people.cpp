#include "fitting/tracking/people.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cheval::fitting::tracking {
namespace {

/// What lies lower is floor, carpet and its noise.
constexpr float kFloorBand = 0.045F;
/// How far beyond the zone limbs may reach and people are still told apart from the wall.
constexpr float kZoneMargin = 0.7F;
/// So far beyond the zone whoever is being dressed has not left it yet.
constexpr float kZoneEdge = 0.2F;
/// Shoes may return no depth; legs begin at least this near the floor.
constexpr float kStandsWithin = 0.32F;
/// Height of a child that can just stand, and above which nothing goes on four legs.
constexpr float kSmallest = 0.72F;
constexpr float kSurelyUpright = 1.05F;
constexpr int kAnimalFrames = 4;
constexpr float kWalkedMetres = 0.35F;
/// What has never walked and has not moved for this long is a mannequin.
constexpr double kMannequinSeconds = 10.0;
/// The same of what has stirred once: people stand still for longer, but pieces of the shop creep.
constexpr double kStillSeconds = 30.0;
constexpr double kForgetSeconds = 2.0;
/// Whoever comes into view moves. What was there before anything was seen has this long to stir.
constexpr float kDoubtSeconds = 1.0F;
/// How far a living person's centroid or spread goes; noise and flicker, which are averaged, stay below.
constexpr float kStirredMetres = 0.010F;
/// Seconds over which they are averaged, and for which what has just come is only looked at.
constexpr float kStirSpan = 0.15F;
constexpr float kSettledSeconds = 0.15F;
/// What goes farther from one frame to the next, metres and metres a second, does not move: it is cut out otherwise.
constexpr float kJump = 0.05F;
constexpr float kJumpSpeed = 2.0F;
/// A centroid that has gone this far has moved; noise and flicker move it by less than a centimetre.
constexpr float kMovedMetres = 0.03F;
/// Seconds over which a person's velocity is averaged.
constexpr float kVelocitySpan = 0.15F;
/// How far behind and before a person's centroid a piece of that person may lie.
constexpr float kDeepestBehind = 0.50F;
constexpr float kFarthestBefore = 1.0F;
/// How far from a person's box that person's hands and belongings may be.
constexpr float kReach = 0.6F;

}  // namespace

bool looksLikePerson(const Component& component, bool floorKnown) {
    const Eigen::Vector3f size = component.upper - component.lower;
    if (component.area < 0.07F || component.area > 1.5F) return false;
    if (size.y() < 0.40F || size.x() > 2.1F || size.z() > 1.6F) return false;
    if (component.upper.y() < (floorKnown ? kSmallest : 0.6F) || component.upper.y() > 2.45F) return false;
    if (floorKnown && looksLikeAnimal(component)) return false;
    if (floorKnown && component.lower.y() > kStandsWithin && !component.touchesBottom) return false;
    // Somebody hides what is behind them; a piece of wall between an arm and a body is itself half hidden.
    if (component.behind > component.before) return false;
    return !looksLikeScenery(component);
}

bool looksLikeAnimal(const Component& component) {
    const Eigen::Vector3f size = component.upper - component.lower;
    // What is low and long goes on four legs; small children are upright. Half of a dog is not long.
    return component.upper.y() < kSurelyUpright &&
           (component.touchesLeft || component.touchesRight || std::hypot(size.x(), size.z()) > 0.9F * size.y());
}

bool looksLikeScenery(const Component& component) {
    const Eigen::Vector3f size = component.upper - component.lower;
    if (component.area > 2.0F || size.x() > 2.4F) return true;
    if (component.touchesLeft && component.touchesRight) return true;
    // Pieces of wall are flat to the sensor's noise; bodies are not.
    const float noise = 0.004F + 0.0019F * component.centroid.z() * component.centroid.z();
    if (component.area > 0.15F && component.roughness < noise) return true;
    // People are slender, or they spread thin arms: what is wide and fills its rectangle is a piece of wall or
    // furniture.
    if (component.wideHeight > 0.22F) return true;
    if (size.x() > 0.72F && component.area > 0.58F * size.x() * size.y()) return true;
    // A shelf, a rail or a box is wide and filled at the top, where a person has a head (or two hands far apart).
    constexpr float kTopBand = 0.14F;
    return component.area > 0.05F && component.topWidth > 0.36F &&
           component.topArea > 0.70F * component.topWidth * std::min(kTopBand, size.y());
}

People::People(const Zone& zone)
    : zone_(zone),
      mask_(kCloudCells),
      componentLabels_(kCloudCells),
      labels_(kCloudCells),
      previousLabels_(kCloudCells),
      previousDepth_(kCloudCells),
      belief_(kCloudCells),
      scratch_(kCloudCells),
      components_(kMaximumComponents + 1) {}

void People::reset() {
    background_.reset();
    std::fill(labels_.begin(), labels_.end(), std::uint8_t{0});
    std::fill(previousLabels_.begin(), previousLabels_.end(), std::uint8_t{0});
    std::fill(previousDepth_.begin(), previousDepth_.end(), 0.0F);
    people_ = {};
    activeId_ = 0;
    started_ = false;
    users_ = {};
}

void People::seeNothing(hal::TimePoint time) {
    std::fill(labels_.begin(), labels_.end(), std::uint8_t{0});
    for (Person& person : people_) {
        person.seen = false;
    }
    forgetTheGone(time);
    chooseActive(time);
    users_.count = 0;
}

void People::update(const Cloud& cloud, hal::TimePoint time, bool floorKnown) {
    const float elapsed = started_ ? std::clamp(static_cast<float>(hal::seconds(time - lastTime_)), 0.0F, 0.5F) : 0.0F;
    first_ = !started_;
    started_ = true;
    lastTime_ = time;
    std::swap(labels_, previousLabels_);
    // A still picture that is shown again and again does not tell who is alive.
    const bool still = std::equal(cloud.depth.begin(), cloud.depth.end(), previousDepth_.begin());
    for (Person& person : people_) {
        if (!still) person.watched += elapsed;
    }

    findForeground(cloud, floorKnown);
    ComponentsJob job{.cloud = &cloud,
                      .mask = mask_,
                      .leastCells = 12,
                      .scratch = scratch_,
                      .labels = componentLabels_,
                      .components = components_};
    job.run();
    componentCount_ = job.count;

    for (Person& person : people_) {
        person.seen = false;
    }
    assignComponents(cloud);
    dropScenery(floorKnown);
    rejoinPieces();
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        if (owner_[i] == 0 && looksLikePerson(components_[i], floorKnown)) adopt(i, time);
    }
    attachFragments();
    labelCells(cloud);
    measurePeople(cloud, time, floorKnown);
    rememberWhole();
    findTheLiving(cloud, elapsed);

    std::copy(cloud.depth.begin(), cloud.depth.end(), previousDepth_.begin());
    judgeCells(cloud);
    background_.learn(cloud, belief_, elapsed);
    findTheHidden(time);
    forgetTheGone(time);
    chooseActive(time);
}

void People::judgeCells(const Cloud& cloud) {
    // A hand or a bag that is not joined to its person must not become part of the shop before the person moves on.
    std::array<Eigen::AlignedBox3f, kMaximumUsers> reach;
    for (std::size_t k = 0; k < kMaximumUsers; ++k) {
        if (!people_[k].seen) continue;
        reach[k] = Eigen::AlignedBox3f(people_[k].user.lower - Eigen::Vector3f(kReach, kReach, kReach),
                                       people_[k].user.upper + Eigen::Vector3f(kReach, kReach, 0.1F));
    }
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const std::uint8_t component = componentLabels_[i];
        if (labels_[i] != 0) {
            belief_[i] = Belief::never;
        } else if (mask_[i] == 0 ||
                   (component != 0 && owner_[component] == 0 && looksLikeScenery(components_[component]))) {
            belief_[i] = Belief::atOnce;
        } else {
            const Eigen::Vector3f point = cloud.point(i);
            const bool within = std::any_of(reach.begin(), reach.end(), [&](const Eigen::AlignedBox3f& box) {
                return !box.isEmpty() && box.contains(point);
            });
            belief_[i] = within ? Belief::inTime : Belief::whereNew;
        }
    }
}

void People::findForeground(const Cloud& cloud, bool floorKnown) {
    // Where nobody knows the floor, nothing may be cut away as floor.
    const float lowest = floorKnown ? kFloorBand : -10.0F;
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const float depth = cloud.depth[i];
        mask_[i] = depth > 0.0F && cloud.y[i] > lowest && cloud.y[i] < 2.7F &&
                           cloud.z[i] < zone_.farMetres + kZoneMargin && background_.isInFront(cloud, i)
                       ? 1
                       : 0;
    }
}

void People::assignComponents(const Cloud& cloud) {
    owner_.fill(0);
    shared_.fill(false);
    // How many cells of each component lay on each person in the frame before.
    std::array<std::array<int, kMaximumUsers>, kMaximumComponents + 1> overlap{};
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        if (componentLabels_[i] != 0 && wasSame(cloud, i)) {
            ++overlap[componentLabels_[i]][previousLabels_[i] - 1U];
        }
    }
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        // A wall that a person touches must not swallow that person's name.
        if (looksLikeScenery(components_[i]) && components_[i].area > 2.5F) continue;
        const auto& cells = overlap[i];
        const auto best = std::max_element(cells.begin(), cells.end());
        const int significant = components_[i].cells / 5;
        if (*best < std::max(4, significant)) continue;
        const auto person = static_cast<std::size_t>(best - cells.begin());
        // The same place at another depth is another thing: somebody who stepped in front, or the wall behind.
        const float behind = components_[i].centroid.z() - people_[person].centroid.z();
        if (people_[person].id == 0 || behind > kDeepestBehind || behind < -kFarthestBefore) continue;
        if (!people_[person].alive && looksLikeScenery(components_[i])) continue;
        owner_[i] = static_cast<std::uint8_t>(person + 1);
        people_[person].seen = true;
        for (std::size_t other = 0; other < kMaximumUsers; ++other) {
            if (other != person && people_[other].id != 0 && cells[other] > significant && cells[other] > 150) {
                shared_[i] = true;
                people_[other].seen = true;
            }
        }
    }
}

void People::dropScenery(bool floorKnown) {
    std::array<bool, kMaximumUsers> whole{};
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        if (owner_[i] != 0 && looksLikePerson(components_[i], floorKnown)) whole[owner_[i] - 1U] = true;
    }
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        if (owner_[i] != 0 && whole[owner_[i] - 1U] && looksLikeScenery(components_[i])) owner_[i] = 0;
    }
}

void People::rejoinPieces() {
    constexpr float kMargin = 0.08F;  // Metres about the box.
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        if (owner_[i] != 0 || looksLikeScenery(components_[i])) continue;
        float nearest = kMargin;
        for (std::size_t k = 0; k < kMaximumUsers; ++k) {
            const Person& person = people_[k];
            if (person.id == 0 || !person.seen || covered(person, person.whole) <= 0.0F) continue;
            const float away = person.whole.exteriorDistance(components_[i].centroid);
            if (away >= nearest) continue;
            nearest = away;
            owner_[i] = static_cast<std::uint8_t>(k + 1);
        }
    }
}

void People::adopt(std::size_t component, hal::TimePoint time) {
    const Eigen::Vector3f& centroid = components_[component].centroid;
    // Somebody who was lost a moment ago, near here, comes back under the same name.
    Person* place = nullptr;
    float nearest = 0.8F;
    for (Person& person : people_) {
        float away = (person.centroid - centroid).norm();
        // Of somebody whom others hid, the last that was seen may have been an arm.
        if (person.hidden) away = std::min(away - 0.5F, person.whole.exteriorDistance(centroid));
        if (person.id != 0 && !person.seen && away < nearest) {
            nearest = away;
            place = &person;
        }
    }
    if (place == nullptr) {
        for (Person& person : people_) {
            if (person.id == 0) {
                place = &person;
                break;
            }
        }
        if (place == nullptr) return;
        *place = Person{};
        place->id = nextId_++;
        place->birthplace = place->restingPlace = centroid;
        place->lastMoved = time;
        place->wasThere = first_;
    }
    place->seen = true;
    place->centroid = centroid;
    owner_[component] = static_cast<std::uint8_t>(place - people_.data() + 1);
}

void People::attachFragments() {
    // Boxes of what is surely each person's.
    std::array<Eigen::AlignedBox3f, kMaximumUsers> boxes;
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        if (owner_[i] == 0) continue;
        boxes[owner_[i] - 1U].extend(components_[i].lower);
        boxes[owner_[i] - 1U].extend(components_[i].upper);
    }
    for (std::size_t i = 1; i <= componentCount_; ++i) {
        const Component& fragment = components_[i];
        if (owner_[i] != 0 || fragment.area > 0.15F || looksLikeScenery(fragment)) continue;
        // Whose box is nearest decides, before anybody's reach does: another's arm is not this person's.
        float nearest = 0.35F;
        std::size_t closest = kMaximumUsers;
        for (std::size_t person = 0; person < kMaximumUsers; ++person) {
            if (boxes[person].isEmpty()) continue;
            const float away = boxes[person].exteriorDistance(fragment.centroid);
            if (away < nearest) {
                nearest = away;
                closest = person;
            }
        }
        for (std::size_t person = 0; person < kMaximumUsers; ++person) {
            if (boxes[person].isEmpty() || (closest != kMaximumUsers && person != closest)) continue;
            // Arms reach towards the sensor and to the sides; behind a person's back there is only scenery.
            Eigen::AlignedBox3f reach = boxes[person];
            reach.min() -= Eigen::Vector3f(0.15F, 0.10F, 0.55F);
            reach.max() += Eigen::Vector3f(0.15F, 0.20F, 0.05F);
            if (!reach.contains(fragment.centroid)) continue;
            if (fragment.centroid.z() > people_[person].centroid.z() + kDeepestBehind) continue;
            owner_[i] = static_cast<std::uint8_t>(person + 1);
        }
    }
}

void People::labelCells(const Cloud& cloud) {
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const std::uint8_t component = componentLabels_[i];
        std::uint8_t label = component == 0 ? std::uint8_t{0} : owner_[component];
        if (component != 0 && shared_[component]) {
            // Two people in one surface: each cell goes to whoever was there, else to the nearer of them.
            const std::uint8_t before = previousLabels_[i];
            if (before != 0 && people_[before - 1U].seen && wasSame(cloud, i)) {
                label = before;
            } else {
                float nearest = 1e3F;
                for (std::size_t person = 0; person < kMaximumUsers; ++person) {
                    if (people_[person].id == 0 || !people_[person].seen) continue;
                    const float away = (people_[person].centroid - cloud.point(i)).norm();
                    if (away < nearest) {
                        nearest = away;
                        label = static_cast<std::uint8_t>(person + 1);
                    }
                }
            }
        }
        labels_[i] = label;
    }
}

void People::measurePeople(const Cloud& cloud, hal::TimePoint time, bool floorKnown) {
    std::array<Component, kMaximumUsers> sums{};
    std::array<Eigen::Vector3f, kMaximumUsers> squares;
    squares.fill(Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        if (labels_[i] == 0) continue;
        const std::size_t k = labels_[i] - 1U;
        Component& sum = sums[k];
        const Eigen::Vector3f point = cloud.point(i);
        sum.lower = sum.cells == 0 ? point : sum.lower.cwiseMin(point);
        sum.upper = sum.cells == 0 ? point : sum.upper.cwiseMax(point);
        sum.centroid += point;
        squares[k] += (point - people_[k].centroid).cwiseAbs2();
        ++sum.cells;
    }
    for (std::size_t k = 0; k < kMaximumUsers; ++k) {
        Person& person = people_[k];
        const Component& sum = sums[k];
        person.seen = person.id != 0 && sum.cells > 60;
        if (!person.seen) continue;
        const auto cells = static_cast<float>(sum.cells);
        const Eigen::Vector3f before = person.centroid;
        person.centroid = sum.centroid / cells;
        person.spread = (squares[k] / cells - (person.centroid - before).cwiseAbs2()).cwiseMax(0.0F).cwiseSqrt();
        const auto elapsed = static_cast<float>(hal::seconds(time - person.measured));
        if (elapsed > 0.0F && elapsed < 0.5F) {
            const float weight = 1.0F - std::exp(-elapsed / kVelocitySpan);
            person.velocity += weight * ((person.centroid - person.measuredAt) / elapsed - person.velocity);
        } else {
            person.velocity.setZero();
        }
        person.measured = time;
        person.measuredAt = person.centroid;
        person.lastSeen = time;
        // Of what was there from the first only what has stirred can walk.
        const Eigen::Vector3f way = person.centroid - person.birthplace;
        if ((person.alive || !person.wasThere) && std::hypot(way.x(), way.z()) > kWalkedMetres) person.walked = true;
        if ((person.centroid - person.restingPlace).norm() > kMovedMetres) {
            person.restingPlace = person.centroid;
            person.lastMoved = time;
        }
        // From the front a dog may look like a small child, for a moment.
        person.tallest = std::max(person.tallest, sum.upper.y());
        const float length = std::hypot(sum.upper.x() - sum.lower.x(), sum.upper.z() - sum.lower.z());
        const bool low = person.tallest < kSurelyUpright && length > 0.9F * (sum.upper.y() - sum.lower.y());
        person.lowFrames = low && floorKnown ? person.lowFrames + 1 : 0;
        const bool still = !person.walked &&
                           hal::seconds(time - person.lastMoved) > (person.alive ? kStillSeconds : kMannequinSeconds);
        if (still || person.lowFrames > kAnimalFrames) {
            person = Person{};
            for (std::size_t i = 0; i < kCloudCells; ++i) {
                if (labels_[i] != k + 1) continue;
                labels_[i] = 0;
                // What stands like furniture goes to the background.
                if (still) mask_[i] = 0;
            }
            continue;
        }
        person.user = User{.id = person.id,
                           .centroid = person.centroid,
                           .velocity = person.velocity,
                           .lower = sum.lower,
                           .upper = sum.upper,
                           .pixels = sum.cells * 4,
                           .label = static_cast<std::uint8_t>(k + 1)};
    }
}

float People::coveredShare(const Person& front, const Eigen::AlignedBox3f& back) {
    if (front.user.upper.z() > back.max().z()) return -1.0F;
    const float depth = back.center().z();
    const float left = std::max(front.user.lower.x() / front.centroid.z(), back.min().x() / depth);
    const float right = std::min(front.user.upper.x() / front.centroid.z(), back.max().x() / depth);
    const float breadth = (back.max().x() - back.min().x()) / depth;
    return breadth > 0.0F ? (right - left) / breadth : -1.0F;
}

float People::covered(const Person& person, const Eigen::AlignedBox3f& box) const {
    float most = -1.0F;
    for (const Person& other : people_) {
        if (other.id != 0 && other.seen && other.id != person.id) most = std::max(most, coveredShare(other, box));
    }
    return most;
}

void People::rememberWhole() {
    constexpr float kBeside = -0.1F;
    for (Person& person : people_) {
        if (person.id == 0 || !person.seen) continue;
        const Eigen::AlignedBox3f box(person.user.lower, person.user.upper);
        if (person.whole.isEmpty() || covered(person, box) < kBeside) person.whole = box;
    }
}

void People::findTheLiving(const Cloud& cloud, float elapsed) {
    for (Person& person : people_) {
        if (!person.seen || person.alive) continue;
        // Whoever passes before a mannequin changes what is seen of it.
        constexpr float kNear = -0.3F;
        const bool disturbed = covered(person, {person.user.lower, person.user.upper}) > kNear;
        const Eigen::Vector3f centroid = 1e-3F * cloud.placement.toSensor(person.centroid);
        // At first the shop about them is still being told apart, and pieces of it grow and shrink.
        const float most = kJump + kJumpSpeed * elapsed;
        const bool jumped = person.wasThere && ((centroid - person.meanCentroid).norm() > most ||
                                                (person.spread - person.meanSpread).norm() > most);
        person.settled = disturbed || jumped ? 0.0F : person.settled + elapsed;
        // Flicker goes to and fro; people go.
        const bool follows = person.wasThere && person.settled > 0.0F;
        const float weight = follows ? 1.0F - std::exp(-elapsed / kStirSpan) : 1.0F;
        person.meanCentroid += weight * (centroid - person.meanCentroid);
        person.meanSpread += weight * (person.spread - person.meanSpread);
        if (person.settled <= kSettledSeconds) {
            person.firstCentroid = person.meanCentroid;
            person.firstSpread = person.meanSpread;
            if (person.wasThere && !disturbed) person.birthplace = person.centroid;
            person.alive = person.walked;
            continue;
        }
        // Shoes and the floor about them come and go; nobody stirs straight up and down.
        const Eigen::Vector3f gone = person.meanCentroid - person.firstCentroid;
        const Eigen::Vector3f grown = person.meanSpread - person.firstSpread;
        person.alive = person.walked || std::hypot(gone.x(), gone.z()) > kStirredMetres ||
                       std::hypot(grown.x(), grown.z()) > kStirredMetres;
    }
}

void People::findTheHidden(hal::TimePoint time) {
    // Whoever stands before somebody covers the same directions, as the sensor sees it from the glass.
    constexpr float kCovers = 0.4F;
    for (Person& person : people_) {
        if (person.id == 0) continue;
        const bool before = person.hidden;
        // Whoever was never seen alone is judged by what was last seen of them.
        const Eigen::AlignedBox3f last(person.user.lower, person.user.upper);
        person.hidden = !person.seen && std::max(covered(person, person.whole), covered(person, last)) > kCovers;
        if (!person.hidden) continue;
        if (!before) person.hiddenSince = time;
        if (hal::seconds(time - person.hiddenSince) < kHiddenSeconds) person.lastSeen = time;
    }
}

void People::forgetTheGone(hal::TimePoint time) {
    for (Person& person : people_) {
        if (person.id != 0 && !person.seen && hal::seconds(time - person.lastSeen) > kForgetSeconds) person = Person{};
    }
}

void People::chooseActive(hal::TimePoint time) {
    users_.count = 0;
    const Person* nearest = nullptr;
    const Person* held = nullptr;
    const auto counts = [&](const Person& person) {
        return person.alive || (person.wasThere && person.watched <= kDoubtSeconds);
    };
    for (const Person& person : people_) {
        if (person.id == 0) continue;
        if (person.id == activeId_) held = &person;
        if (!person.seen) continue;
        users_.users[users_.count++] = person.user;
        if (zone_.contains(person.centroid) && counts(person) &&
            (nearest == nullptr || person.centroid.z() < nearest->centroid.z())) {
            nearest = &person;
        }
    }
    const bool gone = held == nullptr || !counts(*held) || hal::seconds(time - held->lastSeen) > kDwellSeconds ||
                      (held->seen && !zone_.contains(held->centroid, kZoneEdge));
    if (gone) activeId_ = nearest == nullptr ? 0 : nearest->id;
    users_.activeId = activeId_;
}

}  // namespace cheval::fitting::tracking
