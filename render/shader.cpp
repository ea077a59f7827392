#include "render/shader.h"

#include <array>

#include <glad/gl.h>

namespace cheval::render {

// Light comes from the glass's side, as a fitting room's does: a soft key from above, a weak fill from the other side,
// a hemisphere for what the walls give back. Diffuse light is wrapped round the form, and cloth has a faint sheen where
// it turns away (fibres stand up there), never a highlight. Vertices are dense against the light's softness, so that it
// is worked out per vertex, for both faces.
const std::string_view kClothVertexShader = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 textureCoordinate;
uniform mat4 clipFromMirror;
uniform vec2 clipDepth;   // clip z = x * w + y
uniform float depthBias;  // metres towards the eye
uniform vec3 eye;
uniform vec3 exposure;
uniform float sheen;
out vec2 fragmentTexture;
out vec3 frontLight;
out vec3 backLight;

const vec3 kKey = vec3(-0.42, 0.66, -0.62);
const vec3 kFill = vec3(0.78, 0.12, -0.61);

vec3 lightOn(vec3 n, vec3 towardsEye) {
    float key = max((dot(n, kKey) + 0.3) / 1.3, 0.0);
    float fill = max((dot(n, kFill) + 0.4) / 1.4, 0.0);
    vec3 hemisphere = mix(vec3(0.16, 0.15, 0.15), vec3(0.34, 0.35, 0.37), 0.5 + 0.5 * n.y);
    float grazing = 1.0 - clamp(dot(n, towardsEye), 0.0, 1.0);
    float rim = sheen * grazing * grazing * grazing * (0.4 + 0.6 * key);
    return hemisphere + key * key * vec3(0.66, 0.64, 0.61) + fill * fill * vec3(0.14, 0.145, 0.155) + vec3(rim);
}

void main() {
    gl_Position = clipFromMirror * vec4(position, 1.0);
    float w = gl_Position.w;
    gl_Position.z = w * (clipDepth.x + clipDepth.y / max(w - depthBias, 0.05));
    vec3 n = normalize(normal);
    vec3 towardsEye = normalize(eye - position);
    fragmentTexture = textureCoordinate;
    frontLight = exposure * lightOn(n, towardsEye);
    backLight = exposure * lightOn(-n, towardsEye) * 0.62;
}
)";

const std::string_view kClothFragmentShader = R"(
in vec2 fragmentTexture;
in vec3 frontLight;
in vec3 backLight;
uniform sampler2D baseColourTexture;
uniform vec3 baseColour;
out vec4 colour;

// IEC 61966-2-1's curve to within 1 in 255, from square roots.
vec3 toSrgb(vec3 linear) {
    vec3 a = sqrt(linear);
    vec3 b = sqrt(a);
    vec3 c = sqrt(b);
    return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * linear;
}

void main() {
    vec3 albedo = texture(baseColourTexture, fragmentTexture).rgb * baseColour;
    vec3 light = gl_FrontFacing ? frontLight : backLight;
    colour = vec4(toSrgb(clamp(albedo * light, 0.0, 1.0)), 1.0);
}
)";

const std::string_view kDistanceVertexShader = R"(
layout(location = 0) in vec3 position;
uniform mat4 clipFromMirror;
out float metres;
void main() {
    gl_Position = clipFromMirror * vec4(position, 1.0);
    metres = gl_Position.w;
}
)";

const std::string_view kDistanceFragmentShader = R"(
in float metres;
out vec4 colour;
void main() {
    float millimetres = floor(clamp(metres * 1000.0, 0.0, 65535.0) + 0.5);
    float high = floor(millimetres / 256.0);
    colour = vec4(high, millimetres - 256.0 * high, 255.0, 255.0) / 255.0;
}
)";

namespace {

constexpr std::string_view kEsPrelude = "#version 300 es\nprecision highp float;\nprecision highp int;\n";
constexpr std::string_view kCorePrelude = "#version 330 core\n";

Error refused(std::string what, const char* log) {
    return Error{.code = ErrorCode::internal,
                 .cause = std::move(what) + ": " + log,
                 .mend = "report this with the driver's name and version"};
}

Expected<GLuint> compile(const GlContext& context, GLenum kind, std::string_view source) {
    const GladGLContext& gl = context.gl();
    const std::string_view prelude = context.dialect() == Dialect::es3 ? kEsPrelude : kCorePrelude;
    const GLuint shader = gl.CreateShader(kind);
    const std::array<const char*, 2> parts = {prelude.data(), source.data()};
    const std::array<GLint, 2> lengths = {static_cast<GLint>(prelude.size()), static_cast<GLint>(source.size())};
    gl.ShaderSource(shader, 2, parts.data(), lengths.data());
    gl.CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return shader;
    std::array<char, 1024> log{};
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()) - 1, nullptr, log.data());
    gl.DeleteShader(shader);
    return refused("the GL driver refuses a shader", log.data());
}

}  // namespace

Expected<unsigned> makeProgram(const GlContext& context, std::string_view vertex, std::string_view fragment) {
    const GladGLContext& gl = context.gl();
    auto vertexShader = compile(context, GL_VERTEX_SHADER, vertex);
    if (!vertexShader) return std::move(vertexShader).error();
    auto fragmentShader = compile(context, GL_FRAGMENT_SHADER, fragment);
    if (!fragmentShader) {
        gl.DeleteShader(*vertexShader);
        return std::move(fragmentShader).error();
    }
    const GLuint program = gl.CreateProgram();
    gl.AttachShader(program, *vertexShader);
    gl.AttachShader(program, *fragmentShader);
    gl.LinkProgram(program);
    gl.DeleteShader(*vertexShader);
    gl.DeleteShader(*fragmentShader);
    GLint linked = GL_FALSE;
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE) return program;
    std::array<char, 1024> log{};
    gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()) - 1, nullptr, log.data());
    gl.DeleteProgram(program);
    return refused("the GL driver cannot link a program", log.data());
}

}  // namespace cheval::render
