// Fuzzes the loaders of garments and bodies.
#include <span>

#include "fitting/garment/garment.h"
#include "hal/png/png.h"
#include "tests/support/fuzz.h"
#include "tests/support/glb_builder.h"
#include "tests/support/made_body.h"

using namespace cheval;

namespace {

const fitting::Body& body() {
    static const fitting::Body made = test::makeBody();
    return made;
}

// What comes out of a loader must be safe to fit, pose and draw.
void checkMesh(const fitting::RestMesh& mesh) {
    const std::size_t count = mesh.positions.size();
    if (mesh.normals.size() != count || mesh.uv.size() != count || mesh.weights.size() != count) __builtin_trap();
    for (const fitting::Triangle& t : mesh.triangles) {
        if (t.a >= count || t.b >= count || t.c >= count) __builtin_trap();
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!mesh.positions[i].allFinite() || !mesh.normals[i].allFinite()) __builtin_trap();
        for (const std::uint8_t joint : mesh.weights[i].joint) {
            if (joint >= fitting::kJointCount) __builtin_trap();
        }
    }
}

// Bands that rise, one for each size.
void checkSizes(const fitting::SizeChart& chart) {
    if (chart.sizes.empty() || chart.sizes.size() > fitting::kMaximumSizes) __builtin_trap();
    for (const std::vector<float>& edges : chart.edges) {
        if (!edges.empty() && edges.size() != chart.sizes.size() + 1) __builtin_trap();
        for (std::size_t i = 1; i < edges.size(); ++i) {
            if (!(edges[i] > edges[i - 1])) __builtin_trap();
        }
    }
}

// Makes the header's lengths right, since a changed length is all that a search would find otherwise.
void repairLengths(std::vector<std::byte>& bytes) {
    const auto put = [&bytes](std::size_t at, std::size_t value) {
        for (std::size_t i = 0; i < 4; ++i)
            bytes[at + i] = static_cast<std::byte>(value >> (8 * i) & 0xFFU);
    };
    if (bytes.size() < 20) return;
    put(8, bytes.size());
}

void loadBoth(std::span<const std::byte> bytes) {
    const fitting::GarmentLimits limits{.texturePixels = 1U << 16U};
    const auto garment = fitting::parseGarment(bytes, "fuzz.glb", body(), limits);
    if (garment) {
        checkMesh(garment->mesh);
        if (garment->innerCage.size() != body().outerCage.size()) __builtin_trap();
        if (garment->sizes) checkSizes(*garment->sizes);
    }
    const auto mannequin = fitting::parseBody(bytes, "fuzz.glb");
    if (mannequin) checkMesh(mannequin->mesh);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size > 1U << 20U) return 0;
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i)
        bytes[i] = static_cast<std::byte>(data[i]);
    loadBoth(bytes);
    repairLengths(bytes);
    loadBoth(bytes);
    return 0;
}

namespace cheval::test {

std::vector<FuzzInput> fuzzSeeds() {
    std::vector<FuzzInput> seeds;
    const auto add = [&seeds](const GlbBuilder& glb) {
        FuzzInput seed;
        for (const std::byte byte : glb.bytes())
            seed.push_back(static_cast<std::uint8_t>(byte));
        seeds.push_back(seed);
    };
    // A scrap of cloth: small files are searched faster.
    fitting::Garment scrap = makeGarment(body());
    scrap.mesh.triangles.resize(4);
    std::uint32_t last = 0;
    for (const fitting::Triangle& t : scrap.mesh.triangles)
        last = std::max({last, t.a, t.b, t.c});
    scrap.mesh.positions.resize(last + 1);
    scrap.mesh.normals.resize(last + 1);
    scrap.mesh.uv.resize(last + 1);
    scrap.mesh.weights.resize(last + 1);
    scrap.simulated.resize(last + 1);
    add(garmentGlb(scrap, body()));
    GlbBuilder textured = garmentGlb(scrap, body());
    std::vector<std::byte> png;
    if (hal::encodePng(hal::Image<hal::Rgba8>(4, 4, {200, 100, 50, 255}).view(), png)) {
        textured.addTexture(scrap.name, png);
        add(textured);
    }
    GlbBuilder sized = garmentGlb(scrap, body());
    sized.json["asset"]["extras"]["cheval"]["sizes"] = nlohmann::json::parse(
        R"({"for": "women", "unit": "cm", "ease": {"hip_girth": 4},
            "hip_girth": [{"size": "S", "over": 94, "to": 102}, {"size": "M", "over": 102, "to": 110}]})");
    add(sized);
    fitting::Body small = body();
    small.mesh = scrap.mesh;
    add(bodyGlb(small));
    return seeds;
}

}  // namespace cheval::test
