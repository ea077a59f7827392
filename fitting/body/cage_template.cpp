#include "fitting/body/cage_template.h"

#include <bit>

namespace cheval::fitting {
namespace {

class Fnv1a {
  public:
    void add(std::uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) {
            hash_ = (hash_ ^ ((value >> (8 * i)) & 0xFFU)) * 0x100000001B3ULL;
        }
    }
    void add(float value) { add(std::bit_cast<std::uint32_t>(value), 4); }
    [[nodiscard]] std::uint64_t value() const { return hash_; }

  private:
    std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

}  // namespace

std::uint64_t hashCageTemplate(const CageTemplate& cageTemplate) {
    Fnv1a hash;
    hash.add(cageTemplate.uv.size(), 8);
    for (const Eigen::Vector2f& uv : cageTemplate.uv) {
        hash.add(uv.x());
        hash.add(uv.y());
    }
    hash.add(cageTemplate.triangles.size(), 8);
    for (const Triangle& triangle : cageTemplate.triangles) {
        hash.add(triangle.a, 4);
        hash.add(triangle.b, 4);
        hash.add(triangle.c, 4);
    }
    hash.add(cageTemplate.weld.size(), 8);
    for (const std::uint16_t vertex : cageTemplate.weld) {
        hash.add(vertex, 2);
    }
    hash.add(cageTemplate.mirrored.size(), 8);
    for (const std::uint16_t vertex : cageTemplate.mirrored) {
        hash.add(vertex, 2);
    }
    hash.add(cageTemplate.part.size(), 8);
    for (const BodyPart part : cageTemplate.part) {
        hash.add(static_cast<std::uint8_t>(part), 1);
    }
    return hash.value();
}

}  // namespace cheval::fitting
