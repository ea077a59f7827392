// One frame of the simulated world: who is there, how they stand, and what the sensor makes of it.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/image.h"
#include "hal/sim/canvas.h"
#include "hal/sim/room.h"
#include "hal/sim/script.h"
#include "hal/sim/sensor_model.h"
#include "hal/sim/view.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim {

/// Draws frames. Thread-bound; keeps the meshes of the present visit, but no frame depends on those before it. Takes no
/// memory once made.
class Scene {
  public:
    Scene(const WorldOptions& options, const View& view, const Room& room);

    /// Fills both pictures, which have the view's size; an empty `colour` is left alone.
    void render(std::uint64_t frame, double worldSeconds, ImageView<std::uint16_t> depth, ImageView<Rgb8> colour);
    /// What the frame drawn last shows, before the sensor.
    [[nodiscard]] ExactView exact() const;

  private:
    /// One performer as drawn.
    struct Figure {
        Rig rig;
        Mesh mesh;
        Pose pose;
        std::vector<Eigen::Vector3f> positions, normals;
        std::vector<CanvasVertex> vertices;
    };
    void prepare(std::uint32_t visit);
    static void pose(Figure& figure, double seconds);
    PixelBox draw(const Moment& moment, std::size_t which);
    void resolve(const PixelBox& box, ImageView<Rgb8> colour);
    void castShadows(const Performer& performer, const Figure& figure, ImageView<Rgb8> colour) const;

    const WorldOptions& options_;
    const View& view_;
    const Room& room_;
    Canvas canvas_;
    SensorModel sensor_;

    bool prepared_ = false;
    std::uint32_t visit_ = 0;  ///< Whose cast and meshes these are.
    Cast cast_;
    std::vector<Figure> figures_;  ///< One a performer of the cast, and perhaps more.

    PixelBox drawn_;  ///< Where the three pictures differ from the room.
    Image<float> depth_;
    Image<Material> material_;
    Image<std::uint8_t> owner_;
};

}  // namespace cheval::hal::sim
