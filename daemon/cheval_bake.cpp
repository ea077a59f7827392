// cheval-bake: makes the assets. A pure function from its arguments and input files to its output files, one call an
// asset or one call for all, so that any job engine can run it.
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "config/anthropometry.h"
#include "fitting/bake/body_shapes.h"
#include "fitting/bake/glb_writer.h"
#include "fitting/bake/wardrobe.h"

namespace {

using cheval::Expected;
namespace bake = cheval::fitting::bake;

int report(const cheval::Error& error) {
    std::fprintf(stderr, "cheval-bake: %s\n", error.message().c_str());
    return 1;
}

bake::People toPeople(const cheval::config::PeopleTable& table) {
    const auto count = static_cast<Eigen::Index>(table.mean.size());
    bake::People people{.mean = Eigen::Map<const Eigen::VectorXd>(table.mean.data(), count),
                        .covariance = Eigen::MatrixXd::Identity(count, count)};
    for (Eigen::Index i = 1; i < count; ++i) {
        const std::vector<double>& row = table.correlation[static_cast<std::size_t>(i - 1)];
        people.covariance.row(i).head(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), i);
    }
    people.covariance = Eigen::MatrixXd(people.covariance.selfadjointView<Eigen::Lower>());
    // Printed to two digits, the correlations may have lost a little of their definiteness.
    people.covariance.diagonal().array() += 0.01;
    const Eigen::VectorXd deviation = Eigen::Map<const Eigen::VectorXd>(table.standardDeviation.data(), count);
    people.covariance = deviation.asDiagonal() * people.covariance * deviation.asDiagonal();
    return people;
}

Expected<void> setPeople(cheval::fitting::Body& body, const std::string& path) {
    const auto table = cheval::config::loadAnthropometry(path);
    if (!table) return table.error();
    for (std::size_t i = 0; i < table->dimensions.size(); ++i) {
        if (i < cheval::fitting::kShapeParameterCount &&
            table->dimensions[i] == cheval::fitting::kShapeParameterNames[i]) {
            continue;
        }
        return cheval::Error{.code = cheval::ErrorCode::invalidInput,
                             .cause = "dimension " + std::to_string(i + 1) + " is not one of the body model's",
                             .mend = "keep the order of config/anthropometry/adults.toml",
                             .file = path,
                             .key = "dimensions"};
    }
    Expected<void> set = bake::setPeople(body, toPeople(table->women), toPeople(table->men));
    if (set) return set;
    cheval::Error error = std::move(set).error();
    error.file = path;
    return error;
}

/// `people`: the table of what bodies are like.
Expected<void> writeBody(bake::BodyModel& model, const std::string& people, const std::string& path) {
    if (auto set = setPeople(model.body, people); !set) return set;
    auto bytes = bake::encodeBody(model.body);
    if (!bytes) return bytes.error();
    return bake::writeFile(path, bytes.value());
}

Expected<void> writeGarment(const bake::GarmentSpecification& specification, const bake::BodyModel& model,
                            const std::string& path) {
    auto bytes = bake::encodeGarment(bake::makeGarment(specification, model), model.body);
    if (!bytes) return bytes.error();
    return bake::writeFile(path, bytes.value());
}

/// Refuses to cut for a body of another template: its cages would not correspond.
Expected<void> checkBody(const std::string& path, const bake::BodyModel& model) {
    auto hash = bake::readTemplateHash(path);
    if (!hash) return hash.error();
    const std::string ours = bake::hashText(model.body.cageTemplate.hash);
    if (hash.value() != ours) {
        return cheval::Error{
            .code = cheval::ErrorCode::invalidInput,
            .cause = "the body was made on the cage template " + hash.value() + ", not " + ours,
            .mend = "Make the body again with this cheval-bake: cheval-bake body --people FILE --out " + path,
            .why = "garments follow a body through cages of one template",
            .file = path,
            .key = "template_hash"};
    }
    return {};
}

Expected<void> writeWardrobe(const std::string& people, const std::string& folder) {
    bake::BodyModel model = bake::makeBody();
    if (auto written = writeBody(model, people, folder + "/body.glb"); !written) return written;
    for (const bake::GarmentSpecification& garment : bake::wardrobe()) {
        if (auto written = writeGarment(garment, model, folder + "/" + std::string(garment.id) + ".glb"); !written) {
            return written;
        }
    }
    return {};
}

Expected<void> writeOneGarment(const std::string& id, const std::string& bodyPath, const std::string& path) {
    const bake::GarmentSpecification* specification = bake::findGarment(id);
    if (specification == nullptr) {
        std::string known;
        for (const bake::GarmentSpecification& garment : bake::wardrobe()) {
            known += (known.empty() ? "" : ", ") + std::string(garment.id);
        }
        return cheval::Error{.code = cheval::ErrorCode::notFound,
                             .cause = "there is no garment \"" + id + "\"",
                             .mend = "Name one of: " + known + "."};
    }
    const bake::BodyModel model = bake::makeBody();
    if (!bodyPath.empty()) {
        if (auto fits = checkBody(bodyPath, model); !fits) return fits;
    }
    return writeGarment(*specification, model, path);
}

int run(int argc, char** argv) {
    CLI::App app("Makes the mannequin, the garments and the cage template that both share.", "cheval-bake");
    app.require_subcommand(1);
    std::string out;
    std::string id;
    std::string bodyPath;
    std::string people;
    bool printHash = false;

    CLI::App* body = app.add_subcommand("body", "Make the mannequin with its skeleton, weights and cage");
    body->add_option("--out", out, "The .glb file to write")->required();
    const char* const kPeopleHelp = "What bodies are like, e.g. config/anthropometry/adults.toml";
    body->add_option("--people", people, kPeopleHelp)->required();
    CLI::App* garment = app.add_subcommand("garment", "Make one garment of the wardrobe");
    garment->add_option("id", id, "Which garment, e.g. tshirt")->required();
    garment->add_option("--body", bodyPath, "The body.glb that it is for; refused if made on another template");
    garment->add_option("--out", out, "The .glb file to write")->required();
    CLI::App* wardrobe = app.add_subcommand("wardrobe", "Make the mannequin and every garment");
    wardrobe->add_option("--out", out, "The folder to write to")->required();
    wardrobe->add_option("--people", people, kPeopleHelp)->required();
    CLI::App* cageTemplate = app.add_subcommand("template", "Show the cage template");
    cageTemplate->add_flag("--print-hash", printHash, "Print its hash alone");
    CLI::App* list = app.add_subcommand("list", "List the wardrobe: id and name");
    CLI11_PARSE(app, argc, argv);

    Expected<void> done;
    if (body->parsed()) {
        bake::BodyModel model = bake::makeBody();
        done = writeBody(model, people, out);
    } else if (garment->parsed()) {
        done = writeOneGarment(id, bodyPath, out);
    } else if (wardrobe->parsed()) {
        done = writeWardrobe(people, out);
    } else if (list->parsed()) {
        for (const bake::GarmentSpecification& entry : bake::wardrobe()) {
            std::printf("%-16s %s\n", std::string(entry.id).c_str(), std::string(entry.name).c_str());
        }
    } else {
        const cheval::fitting::CageTemplate cage = bake::makeTopology().cageTemplate;
        if (printHash) {
            std::printf("%s\n", bake::hashText(cage.hash).c_str());
        } else {
            std::printf("hash %s, %zu vertices, %zu triangles\n", bake::hashText(cage.hash).c_str(), cage.vertexCount(),
                        cage.triangles.size());
        }
    }
    return done ? 0 : report(done.error());
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "cheval-bake: %s\n", exception.what());
        return 1;
    }
}
