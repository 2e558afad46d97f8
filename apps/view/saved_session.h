// What was open and how it was seen, to return to: a file that the viewer opens as it does models.
//
//   {"sightline_session":1, "files":[{"path":"/models/a.rvm", "beside":"a.rvm"}, …], "y_up":false, "recognise":false,
//    "lenient":false, "older":{"path":"/models/a0.rvm", "beside":"a0.rvm"}, "view":{…}, "views":{…}, "current":0}
//
// "view" and "views" are as in apps/viewpoints/viewpoint.h: camera, sections, measurements, colours, what is hidden,
// faint and selected. "beside" is the path from the session's folder, which counts where "path" is no more, so that a
// folder can be moved with all that is in it. Images of views are not kept.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/apps/common/file_formats.h"
#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/core/error.h"

namespace sightline::apps {

/// How models are read, beside what the command line says.
struct Reading {
  bool recognise = false;  ///< primitives in meshes
  bool lenient = false;    ///< keeps what can be read of damaged files
};

struct SavedSession {
  std::vector<std::string> files;  ///< of models, with absolute paths
  bool y_up = false;               ///< in files that do not say
  Reading reading;
  Viewpoint now;
  std::vector<Viewpoint> views;
  int current = -1;          ///< index of the current view; -1: none
  std::string older = {};    ///< what it is compared with, with its absolute path; or empty
  std::size_t appended = 0;  ///< so many models at the end are new, and shown whatever `now` hides; not kept
  std::string file = {};     ///< that it came from; empty: none; not kept
};

core::Expected<void> write_session(const SavedSession& session, const std::filesystem::path& file);
/// Fails where the file is no session, and where a model is in neither place; without an older revision
/// that is in neither, nothing is compared.
core::Expected<SavedSession> read_session(const std::filesystem::path& file);

/// ".sightline"
FileFormat session_format();

}  // namespace sightline::apps
