#include "sightline/apps/view/file_questions.h"

#include <filesystem>

#include <imgui.h>

#include "sightline/apps/view/exporting.h"
#include "sightline/apps/view/model_exporting.h"
#include "sightline/apps/view/view_list.h"
#include "sightline/apps/view/views.h"

namespace sightline::apps {
namespace {

using Done = core::Expected<void>;
using Purpose = FileRequest::Purpose;

template <Done (*kWork)(Viewer&, const std::string&)>
Done with_one(Viewer& viewer, const std::vector<std::string>& files) {
  return kWork(viewer, files.front());
}

Done open(Viewer& viewer, const std::vector<std::string>& files) {
  return viewer.open(files), Done();
}

Done compare(Viewer& viewer, const std::string& file) {
  return viewer.compare(file), Done();
}

Done save_and_quit(Viewer& viewer, const std::string& file) {
  auto done = save_views(viewer, file);
  if (done) viewer.quit();
  return done;
}

void open_options(Viewer& viewer) {
  ImGui::Checkbox("Recognise primitives in meshes", &viewer.shown.recognise);
}

void compare_options(Viewer&) {
  ImGui::TextUnformatted("What is open counts as the newer revision.");
}

FileRequest models(Viewer&) {
  return {Purpose::kOpenSeveral, "All models", model_formats()};
}

FileRequest older_model(Viewer&) {
  return {Purpose::kOpen, "All models", model_formats()};
}

/// Named after the model.
FileRequest new_image(Viewer& viewer) {
  const std::string stem = std::filesystem::path(viewer.files().front()).stem().string();
  return {Purpose::kSave, "", {png_format()}, stem + ".png"};
}

FileRequest path(Viewer&) {
  return {Purpose::kOpen, "", {json_format()}};
}

FileRequest new_path(Viewer&) {
  return {Purpose::kSave, "", {json_format()}, "path.json"};
}

FileRequest frames_folder(Viewer&) {
  return {Purpose::kFolder, "", {}, "frames"};
}

FileRequest views(Viewer&) {
  return {Purpose::kOpen, "All views", view_formats()};
}

FileRequest new_views(Viewer&) {
  const std::vector<FileFormat> formats = view_formats();
  return {Purpose::kSave, "", formats, "views" + formats.front().extensions.front()};
}

FileRequest new_model(Viewer& viewer) {
  return {Purpose::kSave, "", written_formats(), export_name(viewer, "model")};
}

FileRequest new_selection(Viewer& viewer) {
  return {Purpose::kSave, "", written_formats(), export_name(viewer, "selection")};
}

constexpr FileQuestion kQuestions[] = {
    {Dialog::kOpen, "Open", "Open", true, models, open, open_options},
    {Dialog::kCompare, "Compare with an older revision", "Compare", true, older_model, with_one<compare>,
     compare_options},
    {Dialog::kImage, "Save image", "Save", false, new_image, with_one<write_sized_image>, image_options},
    {Dialog::kReadPath, "Play a camera path", "Play", false, path, with_one<play_path>, nullptr, Dialog::kPath},
    {Dialog::kSavePath, "Save the camera path", "Save", false, new_path, with_one<save_path>, nullptr, Dialog::kPath},
    {Dialog::kFrames, "Folder for the frames", "Write frames", false, frames_folder, with_one<write_sized_frames>},
    {Dialog::kReadViews, "Load views", "Load", false, views, with_one<load_views>},
    {Dialog::kSaveViews, "Save all views", "Save", false, new_views, with_one<save_views>},
    {Dialog::kExportModel, "Export the model", "Export", true, new_model, with_one<export_model>, export_model_options},
    {Dialog::kExportSelection, "Export the selection", "Export", true, new_selection, with_one<export_selection>,
     export_selection_options},
    {Dialog::kSaveAndQuit, "Save all views and quit", "Save and quit", false, new_views, with_one<save_and_quit>},
};

}  // namespace

const FileQuestion* file_question(Dialog dialog) {
  for (const FileQuestion& question : kQuestions)
    if (question.dialog == dialog) return &question;
  return nullptr;
}

}  // namespace sightline::apps
