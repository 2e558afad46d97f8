// What an import noticed, as text in a scene cache.
#include "sightline/importers/slc/internal/slc_rows.h"

namespace sightline::importers {

using nlohmann::json;

std::string to_text(const ImportReport& report) {
  json warnings = json::array();
  for (const ImportWarning& w : report.warnings) warnings.push_back({w.file, w.offset, w.message});
  return to_text(json{{"items", report.items},
                      {"degenerate", report.degenerate},
                      {"shared_meshes", report.shared_meshes},
                      {"attributed", report.attributed},
                      {"sharing_error", report.sharing_error},
                      {"bytes", report.bytes},
                      {"metres_per_unit", report.metres_per_unit},
                      {"warnings", warnings}});
}

core::Expected<ImportReport> report_from(std::string_view text) {
  try {
    const json from = json::parse(text);
    ImportReport report;
    from.at("items").get_to(report.items);
    from.at("degenerate").get_to(report.degenerate);
    from.at("shared_meshes").get_to(report.shared_meshes);
    from.at("attributed").get_to(report.attributed);
    from.at("sharing_error").get_to(report.sharing_error);
    from.at("bytes").get_to(report.bytes);
    from.at("metres_per_unit").get_to(report.metres_per_unit);
    for (const json& w : from.at("warnings")) {
      if (report.warnings.size() > kMaxWarnings) break;
      report.warnings.push_back({w.at(0).get<std::string>(), w.at(1).get<std::uint64_t>(), w.at(2).get<std::string>()});
    }
    return report;
  } catch (const std::exception& wrong) {
    return core::fail(std::string("its report cannot be read: ") + wrong.what());
  }
}

}  // namespace sightline::importers
