#include "fitting/bake/glb_writer.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include "tests/fitting/bake/bake_fixture.h"

namespace cheval::fitting::bake {
namespace {

tinygltf::Model read(const std::vector<std::uint8_t>& bytes) {
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string errors;
    std::string warnings;
    EXPECT_TRUE(
        reader.LoadBinaryFromMemory(&model, &errors, &warnings, bytes.data(), static_cast<unsigned int>(bytes.size())))
        << errors;
    EXPECT_EQ(warnings, "");
    return model;
}

const tinygltf::Node* nodeNamed(const tinygltf::Model& model, const std::string& name) {
    const auto found =
        std::find_if(model.nodes.begin(), model.nodes.end(), [&](const auto& node) { return node.name == name; });
    return found == model.nodes.end() ? nullptr : &*found;
}

const tinygltf::Primitive& primitiveOf(const tinygltf::Model& model, const std::string& name) {
    return model.meshes[static_cast<std::size_t>(nodeNamed(model, name)->mesh)].primitives[0];
}

std::string extra(const tinygltf::Model& model, const std::string& key) {
    return model.asset.extras.Get("cheval").Get(key).Get<std::string>();
}

TEST(GlbWriter, WritesTheBodyAsTheFormatSays) {
    const Body& body = bodyModel().body;
    const tinygltf::Model model = read(encodeBody(body).value());
    EXPECT_EQ(extra(model, "format"), "cheval-body-1");
    EXPECT_EQ(extra(model, "template_hash"), hashText(body.cageTemplate.hash));
    ASSERT_NE(nodeNamed(model, "Body"), nullptr);
    ASSERT_NE(nodeNamed(model, "Body_OuterCage"), nullptr);
    const auto& cage = primitiveOf(model, "Body_OuterCage");
    for (const char* name : {"POSITION", "TEXCOORD_0", "JOINTS_0", "WEIGHTS_0", "_WELD", "_MIRRORED", "_PART"}) {
        ASSERT_TRUE(cage.attributes.contains(name)) << name;
        EXPECT_EQ(model.accessors[static_cast<std::size_t>(cage.attributes.at(name))].count, body.outerCage.size());
    }
    EXPECT_EQ(model.accessors[static_cast<std::size_t>(cage.indices)].count, 3 * body.cageTemplate.triangles.size());
    const auto& skin = primitiveOf(model, "Body");
    for (const char* name : {"POSITION", "NORMAL", "TEXCOORD_0", "JOINTS_0", "WEIGHTS_0"}) {
        ASSERT_TRUE(skin.attributes.contains(name)) << name;
    }
}

TEST(GlbWriter, WritesJointsWhoseGlobalPlacesAreTheirCentres) {
    const Body& body = bodyModel().body;
    const tinygltf::Model model = read(encodeBody(body).value());
    ASSERT_EQ(model.skins.size(), 1U);
    ASSERT_EQ(model.skins[0].joints.size(), kJointCount);
    std::map<int, int> parentOf;
    for (std::size_t n = 0; n < model.nodes.size(); ++n) {
        for (const int child : model.nodes[n].children) {
            parentOf[child] = static_cast<int>(n);
        }
    }
    for (std::size_t j = 0; j < kJointCount; ++j) {
        int node = model.skins[0].joints[j];
        EXPECT_EQ(model.nodes[static_cast<std::size_t>(node)].name, kJointNames[j]);
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
        for (;; node = parentOf.at(node)) {
            const auto& translation = model.nodes[static_cast<std::size_t>(node)].translation;
            place += Eigen::Vector3d(translation[0], translation[1], translation[2]);
            if (!parentOf.contains(node)) break;
        }
        EXPECT_NEAR((place - body.joints[j].cast<double>()).norm(), 0.0, 1e-6) << kJointNames[j];
    }
}

TEST(GlbWriter, WritesGarmentsAsTheFormatSays) {
    const Garment& shirt = garment("tshirt");
    const tinygltf::Model model = read(encodeGarment(shirt, bodyModel().body).value());
    EXPECT_EQ(extra(model, "format"), "cheval-garment-1");
    EXPECT_EQ(extra(model, "name"), "T-shirt");
    EXPECT_EQ(extra(model, "kind"), "top");
    EXPECT_EQ(model.asset.extras.Get("cheval").Get("layer").GetNumberAsInt(), 2);
    EXPECT_NEAR(model.asset.extras.Get("cheval").Get("rigidity").GetNumberAsDouble(), 0.2, 1e-6);
    EXPECT_EQ(extra(model, "template_hash"), hashText(bodyModel().body.cageTemplate.hash));
    ASSERT_NE(nodeNamed(model, "T-shirt"), nullptr);
    ASSERT_NE(nodeNamed(model, "T-shirt_OuterCage"), nullptr);
    EXPECT_TRUE(primitiveOf(model, "T-shirt_InnerCage").attributes.contains("_COVERED"));
    ASSERT_EQ(model.images.size(), 1U);
    EXPECT_EQ(model.images[0].width, shirt.material.baseColourTexture.width);
    const hal::Rgba8& pixel = shirt.material.baseColourTexture.pixels[12345];
    const std::size_t channels = static_cast<std::size_t>(model.images[0].component);
    EXPECT_EQ(model.images[0].image[12345 * channels], pixel.r);
    EXPECT_EQ(model.images[0].image[12345 * channels + 2], pixel.b);
}

TEST(GlbWriter, WritesTheSameBytesEveryTime) {
    EXPECT_EQ(encodeBody(makeBody().body).value(), encodeBody(bodyModel().body).value());
    const Garment again = makeGarment(*findGarment("trousers"), bodyModel());
    EXPECT_EQ(encodeGarment(again, bodyModel().body).value(),
              encodeGarment(garment("trousers"), bodyModel().body).value());
}

class OnDisk : public testing::Test {
  protected:
    OnDisk() { std::filesystem::create_directories(folder_); }
    ~OnDisk() override { std::filesystem::remove_all(folder_); }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    void put(const std::string& name, const std::string& bytes) const {
        std::ofstream(path(name), std::ios::binary) << bytes;
    }

  private:
    std::filesystem::path folder_ =
        std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(OnDisk, ReadsBackTheTemplateThatAnAssetStandsOn) {
    ASSERT_TRUE(writeFile(path("deep/body.glb"), encodeBody(bodyModel().body).value()));
    const auto hash = readTemplateHash(path("deep/body.glb"));
    ASSERT_TRUE(hash);
    EXPECT_EQ(hash.value(), hashText(bodyModel().body.cageTemplate.hash));
    EXPECT_FALSE(std::filesystem::exists(path("deep/body.glb.part")));
}

TEST_F(OnDisk, RefusesFilesThatAreNoAssets) {
    EXPECT_FALSE(readTemplateHash(path("absent.glb")));
    put("text.glb", "This is no glTF, but it is long enough to hold a header.");
    EXPECT_FALSE(readTemplateHash(path("text.glb")));
    const std::string head("glTF\2\0\0\0\xff\xff\0\0", 12);
    put("huge.glb", head + std::string("\xff\xff\xff\x7fJSON", 8) + "{}");
    EXPECT_THAT(readTemplateHash(path("huge.glb")).error().message(), testing::HasSubstr("16 MiB"));
    put("short.glb", head + std::string("\x40\0\0\0JSON", 8) + "{}");
    EXPECT_THAT(readTemplateHash(path("short.glb")).error().message(), testing::HasSubstr("cut short"));
    put("other.glb", head + std::string("\x02\0\0\0JSON", 8) + "{}");
    EXPECT_THAT(readTemplateHash(path("other.glb")).error().message(), testing::HasSubstr("no cage template"));
}

TEST_F(OnDisk, SaysWhenAFileCannotBeWritten) {
    put("file", "x");
    const auto written = writeFile(path("file/below.glb"), {1, 2, 3});
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().file, path("file/below.glb"));
}

}  // namespace
}  // namespace cheval::fitting::bake
