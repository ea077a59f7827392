#include "config/anthropometry.h"

#include <cmath>
#include <optional>
#include <utility>

#include "config/text_file.h"
#include "config/toml_library.h"

namespace cheval::config {

namespace {

constexpr std::size_t kLargestFile = 64U << 10U;
constexpr std::size_t kMostDimensions = 64;

class Reader {
  public:
    Reader(const toml::table& table, const std::string& path) : table_(table), path_(path) {}

    [[nodiscard]] Expected<Anthropometry> read() const {
        Anthropometry result;
        for (const auto& [key, text] : {std::pair("source", &result.source), std::pair("date", &result.date)}) {
            const auto value = table_[key].value<std::string>();
            if (!value || value->empty()) return refuse(key, "it is missing or not a text", table_[key].node());
            *text = *value;
        }
        if (table_["unit"].value<std::string>() != "m") {
            return refuse("unit", "the unit is not \"m\"", table_["unit"].node());
        }
        const toml::array* const names = table_["dimensions"].as_array();
        if (names == nullptr || names->empty() || names->size() > kMostDimensions) {
            return refuse("dimensions", "it is not a list of at most 64 names", table_["dimensions"].node());
        }
        for (const toml::node& name : *names) {
            const auto text = name.value<std::string>();
            if (!text) return refuse("dimensions", "one of them is not a text", &name);
            result.dimensions.push_back(*text);
        }
        for (const auto& [sex, people] : {std::pair("women", &result.women), std::pair("men", &result.men)}) {
            Expected<PeopleTable> table = readPeople(sex, names->size());
            if (!table) return std::move(table).error();
            *people = std::move(*table);
        }
        return result;
    }

  private:
    [[nodiscard]] Expected<PeopleTable> readPeople(const std::string& sex, std::size_t count) const {
        const auto section = table_[sex];
        auto mean = row(section["mean"], sex + ".mean", count);
        if (!mean) return std::move(mean).error();
        auto deviation = row(section["standard_deviation"], sex + ".standard_deviation", count);
        if (!deviation) return std::move(deviation).error();
        for (const double value : *deviation) {
            if (value > 0.0) continue;
            return refuse(sex + ".standard_deviation", "a standard deviation is not positive",
                          section["standard_deviation"].node());
        }
        PeopleTable people{.mean = std::move(*mean), .standardDeviation = std::move(*deviation)};
        for (std::size_t i = 1; i < count; ++i) {
            const std::string key = sex + ".correlation[" + std::to_string(i - 1) + "]";
            auto numbers = row(section["correlation"][i - 1], key, i);
            if (!numbers) return std::move(numbers).error();
            for (const double value : *numbers) {
                if (std::abs(value) <= 1.0) continue;
                return refuse(key, "a correlation is beyond -1 to 1", section["correlation"].node());
            }
            people.correlation.push_back(std::move(*numbers));
        }
        return people;
    }

    template <typename View>
    [[nodiscard]] Expected<std::vector<double>> row(const View& view, const std::string& key, std::size_t count) const {
        const toml::array* const numbers = view.as_array();
        if (numbers == nullptr || numbers->size() != count) {
            return refuse(key, "it is not a list of " + std::to_string(count) + " numbers", view.node());
        }
        std::vector<double> result;
        for (const toml::node& number : *numbers) {
            const std::optional<double> value = number.value<double>();
            if (!value || !std::isfinite(*value)) {
                return refuse(key, "number " + std::to_string(result.size() + 1) + " is not a number", &number);
            }
            result.push_back(*value);
        }
        return result;
    }

    [[nodiscard]] Error refuse(std::string key, std::string cause, const toml::node* node) const {
        return {.code = ErrorCode::invalidInput,
                .cause = std::move(cause),
                .mend = "correct it in the table",
                .why = "the fitted body leans on what bodies are like",
                .file = path_,
                .line = node == nullptr ? 0 : lineOf(node->source()),
                .key = std::move(key)};
    }

    const toml::table& table_;
    const std::string& path_;
};

}  // namespace

Expected<Anthropometry> loadAnthropometry(const std::string& path) {
    Expected<std::string> text = readText(path, kLargestFile, "tables of bodies");
    if (!text) return std::move(text).error();
    const toml::parse_result parsed = toml::parse(*text);
    if (!parsed) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = std::string(parsed.error().description()),
                     .mend = "correct the line",
                     .why = "the table is TOML",
                     .file = path,
                     .line = lineOf(parsed.error().source())};
    }
    return Reader(parsed.table(), path).read();
}

}  // namespace cheval::config
