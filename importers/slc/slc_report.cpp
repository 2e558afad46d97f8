// What an import noticed, as text in a scene cache.
#include "sightline/importers/slc/internal/slc_rows.h"

namespace sightline::importers {

std::string to_text(const ImportReport& report) {
  json::Value warnings = json::Value::array();
  for (const ImportWarning& w : report.warnings) warnings.push_back({w.file, w.offset, w.message});
  return to_text(json::Value{{"items", report.items},
                             {"degenerate", report.degenerate},
                             {"shared_meshes", report.shared_meshes},
                             {"attributed", report.attributed},
                             {"sharing_error", report.sharing_error},
                             {"bytes", report.bytes},
                             {"metres_per_unit", report.metres_per_unit},
                             {"recognition",
                              {{"meshes", report.recognition.meshes},
                               {"items", report.recognition.items},
                               {"triangles", {report.recognition.triangles_before, report.recognition.triangles_after}},
                               {"bytes", {report.recognition.bytes_before, report.recognition.bytes_after}},
                               {"largest_deviation", report.recognition.largest_deviation},
                               {"refused", report.recognition.refused}}},
                             {"surfaces",
                              {{"parts", report.surfaces.parts},
                               {"instances", report.surfaces.instances},
                               {"analytic_solids", report.surfaces.analytic_solids},
                               {"meshed_bodies", report.surfaces.meshed_bodies},
                               {"triangles", report.surfaces.triangles},
                               {"failed_faces", report.surfaces.failed_faces},
                               {"curves", report.surfaces.curves},
                               {"annotations", report.surfaces.annotations},
                               {"largest_tolerance", report.surfaces.largest_tolerance},
                               {"deviation", report.surfaces.deviation},
                               {"analytic_deviation", report.surfaces.analytic_deviation}}},
                             {"warnings", warnings}});
}

core::Expected<ImportReport> report_from(std::string_view text) {
  const auto parsed = json::parse(text);
  if (!parsed) return core::fail("its report cannot be read: " + parsed.error().reason);
  const json::Value& from = *parsed;
  try {
    ImportReport report;
    from.at("items").get_to(report.items);
    from.at("degenerate").get_to(report.degenerate);
    from.at("shared_meshes").get_to(report.shared_meshes);
    from.at("attributed").get_to(report.attributed);
    from.at("sharing_error").get_to(report.sharing_error);
    from.at("bytes").get_to(report.bytes);
    from.at("metres_per_unit").get_to(report.metres_per_unit);
    if (const auto found = from.find("recognition"); found != from.end()) {  // older files have none
      RecognitionReport& recognition = report.recognition;
      found->at("meshes").get_to(recognition.meshes);
      found->at("items").get_to(recognition.items);
      found->at("triangles").at(0).get_to(recognition.triangles_before);
      found->at("triangles").at(1).get_to(recognition.triangles_after);
      found->at("bytes").at(0).get_to(recognition.bytes_before);
      found->at("bytes").at(1).get_to(recognition.bytes_after);
      found->at("largest_deviation").get_to(recognition.largest_deviation);
      found->at("refused").get_to(recognition.refused);
    }
    if (const auto found = from.find("surfaces"); found != from.end()) {  // older files have none
      ExactSurfaceReport& surfaces = report.surfaces;
      found->at("parts").get_to(surfaces.parts);
      found->at("instances").get_to(surfaces.instances);
      found->at("analytic_solids").get_to(surfaces.analytic_solids);
      found->at("meshed_bodies").get_to(surfaces.meshed_bodies);
      found->at("triangles").get_to(surfaces.triangles);
      found->at("failed_faces").get_to(surfaces.failed_faces);
      found->at("curves").get_to(surfaces.curves);
      found->at("annotations").get_to(surfaces.annotations);
      found->at("largest_tolerance").get_to(surfaces.largest_tolerance);
      found->at("deviation").get_to(surfaces.deviation);
      found->at("analytic_deviation").get_to(surfaces.analytic_deviation);
    }
    for (const json::Value& w : from.at("warnings")) {
      if (report.warnings.size() > kMaxWarnings) break;
      report.warnings.push_back({w.at(0).get<std::string>(), w.at(1).get<std::uint64_t>(), w.at(2).get<std::string>()});
    }
    return report;
  } catch (const std::exception& wrong) {
    return core::fail(std::string("its report cannot be read: ") + wrong.what());
  }
}

}  // namespace sightline::importers
