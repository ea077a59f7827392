// One frame of the simulated world: who is there, how they stand, and what the sensor makes of it.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/image.h"
#include "hal/sim/canvas.h"
#include "hal/sim/rig.h"
#include "hal/sim/room.h"
#include "hal/sim/sensor_model.h"
#include "hal/sim/shopper.h"
#include "hal/sim/view.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim {

/// Where a moment falls in the endless row of visits.
struct Moment {
    std::uint32_t visit = 0;
    double scriptTime = 0.0;  ///< Seconds of the script.
    bool visiting = false;    ///< False in the pause after it.
};
Moment momentAt(const WorldOptions& options, double worldSeconds);

/// Draws frames. Thread-bound; keeps the present shopper's mesh, but no frame depends on those before it. Takes no
/// memory once made.
class Scene {
  public:
    Scene(const WorldOptions& options, const View& view, const Room& room);

    /// Fills both pictures, which have the view's size; an empty `colour` is left alone.
    void render(std::uint64_t frame, double worldSeconds, ImageView<std::uint16_t> depth, ImageView<Rgb8> colour);

  private:
    void pose(const Moment& moment);
    void resolve(const PixelBox& box, ImageView<Rgb8> colour);
    void castShadows(ImageView<Rgb8> colour) const;

    const WorldOptions& options_;
    const View& view_;
    const Room& room_;
    Canvas canvas_;
    SensorModel sensor_;

    bool hasShopper_ = false;
    std::uint32_t visit_ = 0;  ///< Whose mesh it is.
    Shopper shopper_;
    Rig rig_;
    Mesh mesh_;
    Pose pose_;
    std::vector<Eigen::Vector3f> positions_, normals_;
    std::vector<CanvasVertex> vertices_;

    PixelBox drawn_;  ///< Where `depth_` and `material_` differ from the room.
    Image<float> depth_;
    Image<Material> material_;
};

}  // namespace cheval::hal::sim
