#include "render/garment_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <glad/gl.h>

#include "render/shader.h"

namespace cheval::render {
namespace {

/// How far each layer is drawn before the one below it: cloth that touches must not flicker (C6).
constexpr float kLayerBias = 0.004F;

Error internal(std::string cause, std::string why) {
    return Error{.code = ErrorCode::internal, .cause = std::move(cause), .why = std::move(why)};
}

const void* bufferOffset(std::size_t bytes) {
    return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr): GL's way to name an offset.
}

}  // namespace

Expected<std::unique_ptr<GarmentPass>> GarmentPass::create(GlContext& context, int width, int height, int distanceSize,
                                                           std::span<const fitting::Material> materials) {
    std::unique_ptr<GarmentPass> pass(new GarmentPass(context, width, height));
    const GladGLContext& gl = context.gl();
    if (auto made = pass->createPrograms(); !made) return std::move(made).error();
    if (auto made = pass->createTarget(pass->colourTarget_, width, height); !made) return std::move(made).error();
    if (auto made = pass->createTarget(pass->distanceTarget_, distanceSize, distanceSize); !made)
        return std::move(made).error();
    gl.GenTextures(1, &pass->white_);
    gl.BindTexture(GL_TEXTURE_2D, pass->white_);
    const std::array<std::uint8_t, 4> white = {255, 255, 255, 255};
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, white.data());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    for (const fitting::Material& material : materials) {
        auto look = pass->createLook(material);
        if (!look) return std::move(look).error();
        pass->looks_.push_back(*look);
    }
    gl.GenVertexArrays(1, &pass->vertexArray_);
    gl.BindVertexArray(pass->vertexArray_);
    gl.GenBuffers(1, &pass->vertexBuffer_);
    gl.GenBuffers(1, &pass->indexBuffer_);
    gl.BindBuffer(GL_ARRAY_BUFFER, pass->vertexBuffer_);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, pass->indexBuffer_);
    constexpr GLsizei kStride = sizeof(fitting::PosedVertex);
    gl.EnableVertexAttribArray(kPositionAttribute);
    gl.EnableVertexAttribArray(kNormalAttribute);
    gl.EnableVertexAttribArray(kTextureAttribute);
    gl.VertexAttribPointer(kPositionAttribute, 3, GL_FLOAT, GL_FALSE, kStride,
                           bufferOffset(offsetof(fitting::PosedVertex, x)));
    gl.VertexAttribPointer(kNormalAttribute, 3, GL_FLOAT, GL_FALSE, kStride,
                           bufferOffset(offsetof(fitting::PosedVertex, nx)));
    gl.VertexAttribPointer(kTextureAttribute, 2, GL_FLOAT, GL_FALSE, kStride,
                           bufferOffset(offsetof(fitting::PosedVertex, u)));
    if (auto warm = pass->warmUp(); !warm) return std::move(warm).error();
    if (auto good = pass->check(); !good) return std::move(good).error();
    return pass;
}

Expected<void> GarmentPass::warmUp() {
    if (looks_.empty()) return {};
    fitting::PosedMesh mesh;
    mesh.vertices = {{.x = -0.1F, .y = -0.1F, .z = 1.0F, .nz = -1.0F},
                     {.x = 0.1F, .y = -0.1F, .z = 1.0F, .nz = -1.0F},
                     {.x = 0.0F, .y = 0.1F, .z = 1.0F, .nz = -1.0F}};
    mesh.indices = {0, 1, 2, 0, 2, 1};  // From either side, so that something is drawn whichever is culled.
    for (std::uint32_t i = 0; i < looks_.size(); ++i)
        mesh.parts.push_back({.indexCount = static_cast<std::uint32_t>(mesh.indices.size()), .material = i});
    if (auto uploaded = upload(mesh); !uploaded) return uploaded;
    constexpr int kSide = 8;
    GarmentView view;
    constexpr float kFocal = kSide;
    constexpr float kMiddle = 0.5F * kSide;
    view.projection << kFocal, 0, kMiddle, 0, 0, -kFocal, kMiddle, 0, 0, 0, 1, 0;
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        drawColour(view, {0, 0, kSide, kSide}, kSide, kSide);
        drawDistance(view, {0, 0, kSide, kSide}, kSide, kSide);
        view.projection(0, 0) = -view.projection(0, 0);
    }
    std::array<hal::Rgba8, std::size_t{kSide} * kSide> drawn{};
    const hal::ImageView<hal::Rgba8> into{.data = drawn.data(), .width = kSide, .height = kSide, .stride = kSide};
    readColour(into);
    readDistance(into);
    hasTopology_ = false;
    return {};
}

GarmentPass::~GarmentPass() {
    if (!context_.makeCurrent()) return;
    const GladGLContext& gl = context_.gl();
    gl.DeleteProgram(cloth_);
    gl.DeleteProgram(distance_);
    gl.DeleteVertexArrays(1, &vertexArray_);
    gl.DeleteBuffers(1, &vertexBuffer_);
    gl.DeleteBuffers(1, &indexBuffer_);
    gl.DeleteTextures(1, &white_);
    for (const Look& look : looks_) {
        if (look.texture != white_) gl.DeleteTextures(1, &look.texture);
    }
    for (const Target* target : {&colourTarget_, &distanceTarget_}) {
        gl.DeleteFramebuffers(1, &target->framebuffer);
        gl.DeleteRenderbuffers(1, &target->colour);
        gl.DeleteRenderbuffers(1, &target->depth);
    }
}

Expected<void> GarmentPass::createPrograms() {
    const GladGLContext& gl = context_.gl();
    auto cloth = makeProgram(context_, kClothVertexShader, kClothFragmentShader);
    if (!cloth) return std::move(cloth).error();
    cloth_ = *cloth;
    auto distance = makeProgram(context_, kDistanceVertexShader, kDistanceFragmentShader);
    if (!distance) return std::move(distance).error();
    distance_ = *distance;
    clothClip_ = gl.GetUniformLocation(cloth_, "clipFromMirror");
    clothClipDepth_ = gl.GetUniformLocation(cloth_, "clipDepth");
    clothBias_ = gl.GetUniformLocation(cloth_, "depthBias");
    clothEye_ = gl.GetUniformLocation(cloth_, "eye");
    clothExposure_ = gl.GetUniformLocation(cloth_, "exposure");
    clothSheen_ = gl.GetUniformLocation(cloth_, "sheen");
    clothBaseColour_ = gl.GetUniformLocation(cloth_, "baseColour");
    distanceClip_ = gl.GetUniformLocation(distance_, "clipFromMirror");
    return {};
}

Expected<void> GarmentPass::createTarget(Target& target, int width, int height) const {
    const GladGLContext& gl = context_.gl();
    GLint limit = 0;
    gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &limit);
    if (width < 1 || height < 1 || width > limit || height > limit)
        return Error{
            .code = ErrorCode::invalidInput,
            .cause = "a picture of " + std::to_string(width) + "×" + std::to_string(height) + " pixels cannot be drawn",
            .mend = "choose a display size from 1 to " + std::to_string(limit)};
    gl.GenFramebuffers(1, &target.framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl.GenRenderbuffers(1, &target.colour);
    gl.BindRenderbuffer(GL_RENDERBUFFER, target.colour);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.colour);
    gl.GenRenderbuffers(1, &target.depth);
    gl.BindRenderbuffer(GL_RENDERBUFFER, target.depth);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target.depth);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return Error{.code = ErrorCode::resource,
                     .cause = "the GL driver gives no picture to draw into",
                     .mend = "check free memory; choose a smaller display"};
    return {};
}

Expected<GarmentPass::Look> GarmentPass::createLook(const fitting::Material& material) const {
    const GladGLContext& gl = context_.gl();
    Look look{.texture = white_,
              .baseColour = material.baseColour.head<3>().cwiseMax(0.0F).cwiseMin(1.0F),
              .sheen = 0.22F * std::clamp(material.roughness, 0.0F, 1.0F),
              .doubleSided = material.doubleSided};
    const hal::Image<hal::Rgba8>& image = material.baseColourTexture;
    if (image.empty()) return look;
    GLint limit = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    const bool whole =
        image.pixels.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (image.width > limit || image.height > limit || !whole)
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the texture of material \"" + material.name + "\" has " + std::to_string(image.width) +
                              "×" + std::to_string(image.height) + " pixels",
                     .mend = "reduce it to at most " + std::to_string(limit) + " on a side",
                     .why = "the GL driver takes no larger textures"};
    gl.GenTextures(1, &look.texture);
    gl.BindTexture(GL_TEXTURE_2D, look.texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                  image.pixels.data());
    gl.GenerateMipmap(GL_TEXTURE_2D);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    return look;
}

Expected<void> GarmentPass::takeTopology(const fitting::PosedMesh& mesh) {
    const GladGLContext& gl = context_.gl();
    hasTopology_ = false;
    parts_.clear();
    for (const fitting::MeshPart& part : mesh.parts) {
        if (part.firstIndex > mesh.indices.size() || part.indexCount > mesh.indices.size() - part.firstIndex)
            return internal("a part of the posed mesh lies beyond its indices", "parts are runs of indices");
        if (part.material >= looks_.size())
            return internal("a part of the posed mesh has material " + std::to_string(part.material) + " of " +
                                std::to_string(looks_.size()),
                            "materials are given to the renderer when it starts");
        if (part.indexCount == 0) continue;
        const auto run = std::span(mesh.indices).subspan(part.firstIndex, part.indexCount);
        const auto [first, last] = std::minmax_element(run.begin(), run.end());
        if (*last >= mesh.vertices.size())
            return internal("the posed mesh has index " + std::to_string(*last) + " but " +
                                std::to_string(mesh.vertices.size()) + " vertices",
                            "indices name vertices");
        parts_.push_back({.part = part, .firstVertex = *first, .lastVertex = *last});
    }
    // What is in front goes first, so that the depth test spares what it hides.
    std::stable_sort(parts_.begin(), parts_.end(),
                     [](const Part& a, const Part& b) { return a.part.layer > b.part.layer; });
    const std::size_t bytes = mesh.indices.size() * sizeof(std::uint32_t);
    if (bytes > indexCapacity_) {
        gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STATIC_DRAW);
        indexCapacity_ = bytes;
    }
    if (bytes > 0) gl.BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes), mesh.indices.data());
    topologyRevision_ = mesh.topologyRevision;
    vertexCount_ = mesh.vertices.size();
    hasTopology_ = true;
    return {};
}

Expected<void> GarmentPass::upload(const fitting::PosedMesh& mesh) {
    const GladGLContext& gl = context_.gl();
    gl.BindVertexArray(vertexArray_);
    gl.BindBuffer(GL_ARRAY_BUFFER, vertexBuffer_);
    if (!hasTopology_ || mesh.topologyRevision != topologyRevision_ || mesh.vertices.size() != vertexCount_) {
        if (auto taken = takeTopology(mesh); !taken) return taken;
    }
    const std::size_t bytes = mesh.vertices.size() * sizeof(fitting::PosedVertex);
    if (bytes > vertexCapacity_) {
        gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_DRAW);
        vertexCapacity_ = bytes;
    }
    if (bytes > 0) gl.BufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes), mesh.vertices.data());
    return {};
}

PixelRect GarmentPass::bounds(const fitting::PosedMesh& mesh, const GarmentView& view) const {
    Eigen::Array2f lower = Eigen::Array2f::Constant(std::numeric_limits<float>::max());
    Eigen::Array2f upper = -lower;
    for (const Part& part : parts_) {
        if (part.part.kind == fitting::PartKind::body && !view.withBody) continue;
        for (std::uint32_t i = part.firstVertex; i <= part.lastVertex; ++i) {
            const fitting::PosedVertex& vertex = mesh.vertices[i];
            const Eigen::Vector3f point = view.projection * Eigen::Vector4f(vertex.x, vertex.y, vertex.z, 1.0F);
            // What reaches behind the eye may cover anything.
            if (point.z() < kNear) return {0, 0, width_, height_};
            const Eigen::Array2f pixel = point.head<2>().array() / point.z();
            lower = lower.min(pixel);
            upper = upper.max(pixel);
        }
    }
    const auto whole = [](float value, int limit) {
        return static_cast<int>(std::clamp(value, 0.0F, static_cast<float>(limit)));
    };
    return {whole(std::floor(lower.x()), width_), whole(std::floor(lower.y()), height_),
            whole(std::ceil(upper.x()), width_), whole(std::ceil(upper.y()), height_)};
}

void GarmentPass::begin(const Target& target, int columns, int rows) const {
    const GladGLContext& gl = context_.gl();
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl.Viewport(0, 0, columns, rows);
    gl.Scissor(0, 0, columns, rows);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl.BindVertexArray(vertexArray_);
}

void GarmentPass::drawColour(const GarmentView& view, const PixelRect& rect, int columns, int rows) {
    const GladGLContext& gl = context_.gl();
    begin(colourTarget_, columns, rows);
    gl.UseProgram(cloth_);
    const Eigen::Matrix4f clip = clipMatrix(view.projection, static_cast<float>(rect.x0), static_cast<float>(rect.y0),
                                            static_cast<float>(rect.width()), static_cast<float>(rect.height()));
    gl.UniformMatrix4fv(clothClip_, 1, GL_FALSE, clip.data());
    gl.Uniform2f(clothClipDepth_, (kFar + kNear) / (kFar - kNear), -2.0F * kFar * kNear / (kFar - kNear));
    const Eigen::Vector3f eye = eyeOf(view.projection);
    gl.Uniform3fv(clothEye_, 1, eye.data());
    gl.Uniform3fv(clothExposure_, 1, view.exposure.data());
    gl.FrontFace(flipsWinding(view.projection) ? GL_CW : GL_CCW);
    gl.CullFace(GL_BACK);
    gl.ActiveTexture(GL_TEXTURE0);
    for (const Part& part : parts_) {
        if (part.part.kind == fitting::PartKind::body && !view.withBody) continue;
        const Look& look = looks_[part.part.material];
        if (look.doubleSided)
            gl.Disable(GL_CULL_FACE);
        else
            gl.Enable(GL_CULL_FACE);
        gl.Uniform1f(clothBias_, kLayerBias * static_cast<float>(part.part.layer));
        gl.Uniform1f(clothSheen_, look.sheen);
        gl.Uniform3fv(clothBaseColour_, 1, look.baseColour.data());
        gl.BindTexture(GL_TEXTURE_2D, look.texture);
        gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(part.part.indexCount), GL_UNSIGNED_INT,
                        bufferOffset(std::size_t{part.part.firstIndex} * sizeof(std::uint32_t)));
    }
    gl.Flush();
}

void GarmentPass::drawDistance(const GarmentView& view, const Eigen::Vector4f& part, int columns, int rows) {
    const GladGLContext& gl = context_.gl();
    begin(distanceTarget_, columns, rows);
    gl.Disable(GL_CULL_FACE);
    gl.UseProgram(distance_);
    const Eigen::Matrix4f clip = clipMatrix(view.projection, part[0], part[1], part[2], part[3]);
    gl.UniformMatrix4fv(distanceClip_, 1, GL_FALSE, clip.data());
    for (const Part& each : parts_) {
        if (each.part.kind == fitting::PartKind::body && !view.withBody) continue;
        gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(each.part.indexCount), GL_UNSIGNED_INT,
                        bufferOffset(std::size_t{each.part.firstIndex} * sizeof(std::uint32_t)));
    }
    gl.Flush();
}

void GarmentPass::read(const Target& target, hal::ImageView<hal::Rgba8> into) const {
    const GladGLContext& gl = context_.gl();
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl.PixelStorei(GL_PACK_ROW_LENGTH, static_cast<GLint>(into.stride));
    gl.ReadPixels(0, 0, into.width, into.height, GL_RGBA, GL_UNSIGNED_BYTE, into.data);
}

void GarmentPass::readColour(hal::ImageView<hal::Rgba8> into) const {
    read(colourTarget_, into);
}

void GarmentPass::readDistance(hal::ImageView<hal::Rgba8> into) const {
    read(distanceTarget_, into);
}

Expected<void> GarmentPass::check() const {
    const GLenum error = context_.gl().GetError();
    if (error == GL_NO_ERROR) return {};
    return Error{.code = error == GL_OUT_OF_MEMORY ? ErrorCode::resource : ErrorCode::internal,
                 .cause = "GL reports error " + std::to_string(error),
                 .mend = error == GL_OUT_OF_MEMORY ? "check free memory" : "report this with the driver's version"};
}

}  // namespace cheval::render
