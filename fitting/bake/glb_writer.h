// Writes bodies and garments as binary glTF 2.0 (format: fitting/garment/FORMAT.md). The same input gives the same
// bytes: no times, no names of machines, fixed order.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fitting/body/body.h"
#include "fitting/garment/garment.h"
#include "hal/expected.h"

namespace cheval::fitting::bake {

/// The bytes of a body asset.
Expected<std::vector<std::uint8_t>> encodeBody(const Body& body);

/// The bytes of a garment asset cut for `body`.
Expected<std::vector<std::uint8_t>> encodeGarment(const Garment& garment, const Body& body);

/// Writes a whole file beside the target and renames it into place, so that no reader sees half of it.
Expected<void> writeFile(const std::string& path, const std::vector<std::uint8_t>& bytes);

/// The template hash that an asset of ours says it was made on. Refuses what is no .glb of ours.
Expected<std::string> readTemplateHash(const std::string& path);

/// The template hash as assets carry it: 16 lower-case hexadecimal digits.
std::string hashText(std::uint64_t hash);

}  // namespace cheval::fitting::bake
