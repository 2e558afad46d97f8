// Views and camera paths.
#include "sightline/importers/view_json.h"
#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile {
namespace {

Case absurd_number(std::size_t k) {
  const std::vector<std::string> numbers = {"1e999", "-1e308", "1" + repeated("0", 100000), "4.9e-324", "-0"};
  const std::string& n = numbers[k];
  return refused(one_file("model.json", R"({"eye":[0,0,)" + n + R"(],"target":[1,0,0],"fovy_deg":60,"near":)" + n +
                                            R"(,"layers":)" + n + R"(,"keys":[{"t":)" + n +
                                            R"(,"eye":[0,0,1],"target":[1,0,)" + n + R"(],"fovy_deg":)" + n + "}]}"));
}

Case nested_json(std::size_t k) {
  const std::vector<std::string> opening = {"[", "{\"a\":", "[{\"a\":"};
  return refused(one_file("model.json", repeated(opening[k], 1000000)));
}

template <class Value>
core::Expected<importers::ImportReport> report_of(const core::Expected<Value>& read) {
  if (!read) return tl::unexpected(read.error());
  return importers::ImportReport();
}

template <auto parse>
core::Expected<importers::ImportReport> read_text(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                                  core::Scene&, core::NodeId, const importers::ImportOptions&) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return report_of(parse(text, path.filename().string()));
}

core::Expected<core::View> parse_view(std::string_view text, const std::string& name) {
  return importers::parse_view(text, 1.5, name);
}

Needs all_but_white_space(std::string_view seed) {
  const std::size_t size = seed.find_last_not_of(" \n") + 1;
  return {size, size};
}

}  // namespace

std::vector<Target> json_targets() {
  Target views;
  views = {.format = "view_json",
           .extension = ".json",
           .read = read_text<parse_view>,
           .mutations = 20000,
           .attacks = {{"absurd_numbers", 5, absurd_number}, {"deep_nesting", 3, nested_json}},
           .needs = all_but_white_space};
  Target paths = views;
  paths.format = "path_json";
  paths.read = read_text<importers::parse_path>;
  return {views, paths};
}

}  // namespace sightline::hostile
