// The shaders, one set for both dialects, and how they are compiled.
#pragma once

#include <string>
#include <string_view>

#include "hal/expected.h"
#include "render/gl_context.h"

namespace cheval::render {

inline constexpr unsigned kPositionAttribute = 0;
inline constexpr unsigned kNormalAttribute = 1;
inline constexpr unsigned kTextureAttribute = 2;

/// Cloth: lit per vertex, textured per fragment, sRGB out.
extern const std::string_view kClothVertexShader;
extern const std::string_view kClothFragmentShader;
/// Distance along the camera's axis in whole millimetres: red the high byte, green the low one, blue 1.
extern const std::string_view kDistanceVertexShader;
extern const std::string_view kDistanceFragmentShader;

/// Compiles and links, with the dialect's prelude before each. The program is the caller's to delete. Fails with the
/// compiler's log.
Expected<unsigned> makeProgram(const GlContext& context, std::string_view vertex, std::string_view fragment);

}  // namespace cheval::render
