#include "fitting/garment/garment.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/png/png.h"
#include "tests/support/glb_builder.h"
#include "tests/support/made_body.h"

using namespace cheval;
using namespace cheval::fitting;
using test::GlbBuilder;
using testing::HasSubstr;

namespace {

struct Shop {
    Body body = test::makeBody();
    Garment top = test::makeGarment(body);
    GlbBuilder glb = test::garmentGlb(top, body);

    [[nodiscard]] Expected<Garment> load(const GarmentLimits& limits = {}) const {
        return parseGarment(glb.bytes(), "shop/top.glb", body.cageTemplate, limits);
    }
    void setFloat(const std::string& node, const std::string& attribute, std::size_t number, float value) {
        std::memcpy(glb.data(node, attribute) + 4 * number, &value, sizeof value);
    }
    void setIndex(std::size_t number, std::uint32_t value) {
        std::memcpy(glb.data("Top", "indices") + 4 * number, &value, sizeof value);
    }
};

void expectRefusal(const Expected<Garment>& loaded, const std::string& what) {
    ASSERT_FALSE(loaded.hasValue()) << "expected: " << what;
    EXPECT_EQ(loaded.error().code, ErrorCode::invalidInput);
    EXPECT_THAT(loaded.error().message(), HasSubstr(what));
    EXPECT_EQ(loaded.error().file, "shop/top.glb");
    EXPECT_FALSE(loaded.error().cause.empty());
    EXPECT_FALSE(loaded.error().mend.empty());
    EXPECT_FALSE(loaded.error().why.empty());
}

}  // namespace

TEST(GarmentLoader, ReadsBackWhatWasWritten) {
    const Shop shop;
    const auto loaded = shop.load();
    ASSERT_TRUE(loaded.hasValue()) << loaded.error().message();
    EXPECT_EQ(loaded->id, "top");
    EXPECT_EQ(loaded->name, "Top");
    EXPECT_EQ(loaded->kind, GarmentKind::top);
    EXPECT_EQ(loaded->layerOrder, 1);
    EXPECT_FLOAT_EQ(loaded->rigidity, 0.25F);
    EXPECT_EQ(loaded->mesh.positions, shop.top.mesh.positions);
    EXPECT_EQ(loaded->mesh.triangles, shop.top.mesh.triangles);
    EXPECT_EQ(loaded->innerCage, shop.top.innerCage);
    EXPECT_EQ(loaded->outerCage, shop.top.outerCage);
    EXPECT_EQ(loaded->covered, shop.top.covered);
    EXPECT_EQ(loaded->simulated.size(), shop.top.mesh.positions.size());
    for (std::size_t i = 0; i < shop.top.mesh.weights.size(); ++i) {
        EXPECT_EQ(loaded->mesh.weights[i].joint[0], shop.top.mesh.weights[i].joint[0]);
        EXPECT_NEAR(loaded->mesh.weights[i].weight[0], shop.top.mesh.weights[i].weight[0], 1e-6F);
    }
}

TEST(GarmentLoader, BringsCageVerticesIntoTemplateOrder) {
    Shop shop;
    // The same cage with its vertices turned round: the UV alone says which is which.
    RestMesh turned;
    turned.positions.assign(shop.top.innerCage.rbegin(), shop.top.innerCage.rend());
    turned.uv.assign(shop.body.cageTemplate.uv.rbegin(), shop.body.cageTemplate.uv.rend());
    shop.glb.removeNode("Top_InnerCage");
    shop.glb.addMesh("Top_InnerCage", turned);
    shop.glb.addScalar("Top_InnerCage", "_COVERED",
                       std::vector<float>(shop.top.covered.rbegin(), shop.top.covered.rend()));
    const auto loaded = shop.load();
    ASSERT_TRUE(loaded.hasValue()) << loaded.error().message();
    EXPECT_EQ(loaded->innerCage, shop.top.innerCage);
    EXPECT_EQ(loaded->covered, shop.top.covered);
}

TEST(GarmentLoader, ReadsJointsByNameInAnyOrder) {
    Shop shop;
    nlohmann::json& joints = shop.glb.json["skins"][0]["joints"];
    std::swap(joints[index(Joint::torso)], joints[index(Joint::leftShoulder)]);
    const auto loaded = shop.load();
    ASSERT_TRUE(loaded.hasValue());
    for (std::size_t i = 0; i < shop.top.mesh.weights.size(); ++i) {
        const std::uint8_t written = shop.top.mesh.weights[i].joint[0];
        const auto expected = written == index(Joint::torso)          ? index(Joint::leftShoulder)
                              : written == index(Joint::leftShoulder) ? index(Joint::torso)
                                                                      : written;
        EXPECT_EQ(loaded->mesh.weights[i].joint[0], expected);
    }
}

TEST(GarmentLoader, ReadsTheTexture) {
    Shop shop;
    hal::Image<hal::Rgba8> picture(3, 2, {10, 20, 30, 255});
    std::vector<std::byte> png;
    ASSERT_TRUE(hal::encodePng(picture.view(), png).hasValue());
    shop.glb.addTexture("Top", png);
    const auto loaded = shop.load();
    ASSERT_TRUE(loaded.hasValue()) << loaded.error().message();
    EXPECT_EQ(loaded->material.baseColourTexture.width, 3);
    EXPECT_EQ(loaded->material.baseColourTexture.pixels, picture.pixels);
    expectRefusal(shop.load({.texturePixels = 5}), "texture");
    png.resize(png.size() / 2);
    Shop cut;
    cut.glb.addTexture("Top", png);
    expectRefusal(cut.load(), "texture");
}

TEST(GarmentLoader, TakesWeightsFromTheBodyWhereTheFileHasNone) {
    Shop shop;
    shop.glb.primitive("Top")["attributes"].erase("JOINTS_0");
    shop.glb.primitive("Top")["attributes"].erase("WEIGHTS_0");
    expectRefusal(shop.load(), "JOINTS_0");
    const auto loaded = parseGarment(shop.glb.bytes(), "shop/top.glb", shop.body);
    ASSERT_TRUE(loaded.hasValue()) << loaded.error().message();
    EXPECT_EQ(loaded->mesh.weights.size(), shop.top.mesh.positions.size());
}

struct BadGarment {
    const char* what;
    std::function<void(Shop&)> spoil;
    const char* expected;
};

class RefusedGarment : public testing::TestWithParam<BadGarment> {};

TEST_P(RefusedGarment, SaysWhatIsWrongWhatToDoAndWhy) {
    Shop shop;
    GetParam().spoil(shop);
    expectRefusal(shop.load(), GetParam().expected);
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

INSTANTIATE_TEST_SUITE_P(
    GarmentLoader, RefusedGarment,
    testing::Values(
        BadGarment{"NoInnerCage", [](Shop& s) { s.glb.removeNode("Top_InnerCage"); }, "Top_InnerCage"},
        BadGarment{"NoOuterCage", [](Shop& s) { s.glb.removeNode("Top_OuterCage"); }, "Top_OuterCage"},
        BadGarment{"NoMesh", [](Shop& s) { s.glb.removeNode("Top"); }, "Top"},
        BadGarment{"OtherVertexCount",
                   [](Shop& s) {
                       for (const char* name : {"POSITION", "TEXCOORD_0"}) {
                           auto& accessor = s.glb.accessor("Top_OuterCage", name);
                           accessor["count"] = accessor["count"].get<int>() - 9;
                       }
                       s.glb.primitive("Top_OuterCage").erase("indices");
                   },
                   "vertices"},
        BadGarment{"MovedUv", [](Shop& s) { s.setFloat("Top_InnerCage", "TEXCOORD_0", 2 * 17, 0.6001F); }, "vertex 17"},
        BadGarment{"UvOfAnother",
                   [](Shop& s) {
                       s.setFloat("Top_InnerCage", "TEXCOORD_0", 2 * 17, s.body.cageTemplate.uv[20].x());
                       s.setFloat("Top_InnerCage", "TEXCOORD_0", 2 * 17 + 1, s.body.cageTemplate.uv[20].y());
                   },
                   "vertices 17 and 20"},
        BadGarment{"TornSeam", [](Shop& s) { s.setFloat("Top_OuterCage", "POSITION", 3 * 8 + 1, 0.9F); }, "seam"},
        BadGarment{"NanPosition", [](Shop& s) { s.setFloat("Top", "POSITION", 5, kNan); }, "not finite"},
        BadGarment{"InfiniteCage", [](Shop& s) { s.setFloat("Top_OuterCage", "POSITION", 5, kInfinity); },
                   "not finite"},
        BadGarment{"NanNormal", [](Shop& s) { s.setFloat("Top", "NORMAL", 5, kNan); }, "NORMAL"},
        BadGarment{"NanUv", [](Shop& s) { s.setFloat("Top_InnerCage", "TEXCOORD_0", 5, kNan); }, "TEXCOORD_0"},
        BadGarment{"NanWeight", [](Shop& s) { s.setFloat("Top", "WEIGHTS_0", 5, kNan); }, "WEIGHTS_0"},
        BadGarment{"WeightsThatDoNotSum", [](Shop& s) { s.setFloat("Top", "WEIGHTS_0", 4 * 3, 0.4F); }, "vertex 3"},
        BadGarment{"NegativeWeight", [](Shop& s) { s.setFloat("Top", "WEIGHTS_0", 4 * 3, -1.0F); }, "vertex 3"},
        BadGarment{"JointThatIsNotThere", [](Shop& s) { s.glb.data("Top", "JOINTS_0")[0] = 200; }, "joint"},
        BadGarment{"UnknownJointName",
                   [](Shop& s) {
                       for (auto& node : s.glb.json["nodes"]) {
                           if (node["name"] == "left_elbow") node["name"] = "tail";
                       }
                   },
                   "tail"},
        BadGarment{"NoSkin",
                   [](Shop& s) {
                       s.glb.json.erase("skins");
                       for (auto& n : s.glb.json["nodes"])
                           n.erase("skin");
                   },
                   "skin"},
        BadGarment{"HugeIndex", [](Shop& s) { s.setIndex(7, 4'000'000'000U); }, "4000000000"},
        BadGarment{"NoCoverage", [](Shop& s) { s.glb.primitive("Top_InnerCage")["attributes"].erase("_COVERED"); },
                   "_COVERED"},
        BadGarment{"CoversNothing",
                   [](Shop& s) {
                       for (std::size_t i = 0; i < s.top.covered.size(); ++i)
                           s.setFloat("Top_InnerCage", "_COVERED", i, 0.0F);
                   },
                   "covers no triangle"},
        BadGarment{"BufferOfTwoGibibytes",
                   [](Shop& s) {
                       s.glb.json["buffers"] = {{{"byteLength", 2147483648U}}};
                   },
                   "2048 MiB"},
        BadGarment{"ViewBeyondTheBuffer", [](Shop& s) { s.glb.json["bufferViews"][0]["byteLength"] = 2147483647U; },
                   "bufferViews[0]"},
        BadGarment{"ViewOffsetThatWrapsRound",
                   [](Shop& s) { s.glb.json["bufferViews"][0]["byteOffset"] = 9007199254740990U; }, "bufferViews[0]"},
        BadGarment{"AccessorBeyondItsView", [](Shop& s) { s.glb.accessor("Top", "POSITION")["byteOffset"] = 12; },
                   "outside its buffer view"},
        BadGarment{"CountOfMillions", [](Shop& s) { s.glb.accessor("Top", "POSITION")["count"] = 500'000'000; },
                   "500000000"},
        BadGarment{"NegativeCount", [](Shop& s) { s.glb.accessor("Top", "POSITION")["count"] = -3; }, "accessors"},
        BadGarment{"FractionalCount", [](Shop& s) { s.glb.accessor("Top", "POSITION")["count"] = 3.5; }, "accessors"},
        BadGarment{"StrideThatIsTooSmall",
                   [](Shop& s) {
                       s.glb.json["bufferViews"][s.glb.accessor("Top", "POSITION")["bufferView"].get<std::size_t>()]
                                 ["byteStride"] = 8;
                   },
                   "outside its buffer view"},
        BadGarment{"Sparse",
                   [](Shop& s) {
                       s.glb.accessor("Top", "POSITION")["sparse"] = {{"count", 1}};
                   },
                   "sparse"},
        BadGarment{"WrongComponentType", [](Shop& s) { s.glb.accessor("Top", "POSITION")["componentType"] = 5130; },
                   "component type"},
        BadGarment{"PositionsAsShorts", [](Shop& s) { s.glb.accessor("Top", "POSITION")["componentType"] = 5123; },
                   "POSITION"},
        BadGarment{"AttributeThatIsNotThere", [](Shop& s) { s.glb.primitive("Top")["attributes"]["POSITION"] = 999; },
                   "not there"},
        BadGarment{"IndicesThatAreNotThere", [](Shop& s) { s.glb.primitive("Top")["indices"] = 999; }, "not there"},
        BadGarment{"Lines", [](Shop& s) { s.glb.primitive("Top")["mode"] = 1; }, "triangles"},
        BadGarment{"ExternalBuffer",
                   [](Shop& s) {
                       s.glb.json["buffers"] = {{{"byteLength", 16}, {"uri", "../../etc/passwd"}}};
                   },
                   "another file"},
        BadGarment{"ExternalTexture",
                   [](Shop& s) {
                       s.glb.json["images"] = {{{"uri", "http://example.org/a.png"}}};
                   },
                   "another file"},
        BadGarment{"NeededExtension",
                   [](Shop& s) { s.glb.json["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }, "extensions"},
        BadGarment{"TooManyNodes",
                   [](Shop& s) {
                       for (int i = 0; i < 300; ++i)
                           s.glb.json["nodes"].push_back({{"name", "x"}});
                   },
                   "nodes"},
        BadGarment{"DeeplyNestedJson",
                   [](Shop& s) {
                       nlohmann::json nest = 1;
                       for (int i = 0; i < 200; ++i)
                           nest = nlohmann::json::array({nest});
                       s.glb.json["asset"]["extras"]["deep"] = nest;
                   },
                   "cannot be read"},
        BadGarment{"NodesInACircle",
                   [](Shop& s) {
                       s.glb.json["nodes"][0]["children"] = {1};
                       s.glb.json["nodes"][1]["children"] = {0};
                   },
                   "transforms"},
        BadGarment{"MovedNode",
                   [](Shop& s) {
                       s.glb.json["nodes"][0]["translation"] = {0, 1, 0};
                   },
                   "moved"},
        BadGarment{"OtherTemplate",
                   [](Shop& s) { s.glb.json["asset"]["extras"]["cheval"]["template_hash"] = "0123456789abcdef"; },
                   "another cage template"},
        BadGarment{"HashThatIsNone", [](Shop& s) { s.glb.json["asset"]["extras"]["cheval"]["template_hash"] = "12"; },
                   "16 hexadecimal"},
        BadGarment{"OtherFormat", [](Shop& s) { s.glb.json["asset"]["extras"]["cheval"]["format"] = "cheval-body-1"; },
                   "cheval-garment-1"},
        BadGarment{"NoExtras", [](Shop& s) { s.glb.json["asset"].erase("extras"); }, "format"},
        BadGarment{"UnknownKind", [](Shop& s) { s.glb.json["asset"]["extras"]["cheval"]["kind"] = "sock"; }, "sock"},
        BadGarment{"LayerZero", [](Shop& s) { s.glb.json["asset"]["extras"]["cheval"]["layer"] = 0; }, "1 to 8"},
        BadGarment{"RigidityOfTwo", [](Shop& s) { s.glb.json["asset"]["extras"]["cheval"]["rigidity"] = 2.0; },
                   "rigidity"},
        BadGarment{"NoSize",
                   [](Shop& s) {
                       for (std::size_t i = 0; i < 3 * s.top.mesh.positions.size(); ++i)
                           s.setFloat("Top", "POSITION", i, 1.0F);
                   },
                   "no size"}),
    [](const testing::TestParamInfo<BadGarment>& test) { return std::string(test.param.what); });

TEST(GarmentLoader, RefusesEveryTruncation) {
    const Shop shop;
    const std::vector<std::byte> whole = shop.glb.bytes();
    for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97) {
        const std::span<const std::byte> part(whole.data(), size);
        expectRefusal(parseGarment(part, "shop/top.glb", shop.body.cageTemplate), "");
    }
}

TEST(GarmentLoader, RefusesAHeaderThatClaimsTwoGibibytes) {
    const Shop shop;
    std::vector<std::byte> bytes = shop.glb.bytes();
    bytes[11] = std::byte{0x80};
    expectRefusal(parseGarment(bytes, "shop/top.glb", shop.body.cageTemplate), "truncated");
    bytes = shop.glb.bytes();
    bytes[15] = std::byte{0x80};  // The JSON chunk's length.
    expectRefusal(parseGarment(bytes, "shop/top.glb", shop.body.cageTemplate), "claims 2048 MiB");
}

TEST(GarmentLoader, HoldsToItsLimits) {
    const Shop shop;
    expectRefusal(shop.load({.fileBytes = 1000}), "the file has");
    expectRefusal(shop.load({.triangles = 10}), "");
}

TEST(GarmentLoader, SaysWhenThereIsNoFile) {
    const Shop shop;
    const auto loaded = loadGarment("no-such-folder/coat.glb", shop.body.cageTemplate);
    ASSERT_FALSE(loaded.hasValue());
    EXPECT_EQ(loaded.error().code, ErrorCode::notFound);
    EXPECT_EQ(loaded.error().file, "no-such-folder/coat.glb");
}

TEST(GarmentLoader, LoadsAFile) {
    const Shop shop;
    const std::string path = testing::TempDir() + "cheval-top.glb";
    const std::vector<std::byte> bytes = shop.glb.bytes();
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const auto loaded = loadGarment(path, shop.body);
    std::filesystem::remove(path);
    ASSERT_TRUE(loaded.hasValue()) << loaded.error().message();
    EXPECT_EQ(loaded->id, "cheval-top");
}
