#include "sightline/apps/view/file_questions.h"

#include <filesystem>

#include <imgui.h>

#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/view_list.h"

namespace sightline::apps {
namespace {

using Purpose = FileRequest::Purpose;

template <Done (*kWork)(Workspace&, const std::string&)>
Done with_one(Workspace& work, const std::vector<std::string>& files) {
  return kWork(work, files.front());
}

Done open(Workspace& work, const std::vector<std::string>& files) {
  return work.open(files), Done();
}

Done save_and_quit(Workspace& work, const std::string& file) {
  auto done = with<save_views>(work, file);
  if (done) work.window.close();
  return done;
}

void open_options(Workspace& work) {
  ImGui::Checkbox("Recognise primitives in meshes", &work.shown.recognise);
}

void compare_options(Workspace&) {
  ImGui::TextUnformatted("What is open counts as the newer revision.");
}

FileRequest models(Workspace&) {
  std::vector<FileFormat> formats = model_formats();
  formats.push_back(session_format());
  return {Purpose::kOpenSeveral, "All models", formats};
}

FileRequest more_models(Workspace&) {
  return {Purpose::kOpenSeveral, "All models", model_formats()};
}

/// Named as before, or after the model.
FileRequest new_session(Workspace& work) {
  if (!work.session_file.empty()) return {Purpose::kSave, "", {session_format()}, work.session_file};
  const std::string stem = std::filesystem::path(work.files().front()).stem().string();
  return {Purpose::kSave, "", {session_format()}, stem + ".sightline"};
}

FileRequest older_model(Workspace&) {
  return {Purpose::kOpen, "All models", model_formats()};
}

/// Named after the model.
FileRequest new_image(Workspace& work) {
  const std::string stem = std::filesystem::path(work.files().front()).stem().string();
  return {Purpose::kSave, "", {png_format(), jpeg_format()}, stem + ".png"};
}

FileRequest path(Workspace&) {
  return {Purpose::kOpen, "", {json_format()}};
}

FileRequest new_path(Workspace&) {
  return {Purpose::kSave, "", {json_format()}, "path.json"};
}

FileRequest frames_folder(Workspace&) {
  return {Purpose::kFolder, "", {}, "frames"};
}

FileRequest views(Workspace&) {
  return {Purpose::kOpen, "All views", view_formats()};
}

FileRequest new_views(Workspace&) {
  const std::vector<FileFormat> formats = view_formats();
  return {Purpose::kSave, "", formats, "views" + formats.front().extensions.front()};
}

FileRequest new_model(Workspace& work) {
  return {Purpose::kSave, "", written_formats(), export_name(work, "model")};
}

FileRequest new_selection(Workspace& work) {
  return {Purpose::kSave, "", written_formats(), export_name(work, "selection")};
}

constexpr FileQuestion kQuestions[] = {
    {Dialog::kOpen, "Open", "Open", true, models, open, open_options},
    {Dialog::kCompare, "Compare with an older revision", "Compare", true, older_model, with_one<compare_with>,
     compare_options},
    {Dialog::kImage, "Save image", "Save", false, new_image, with_one<write_sized_image>, image_options},
    {Dialog::kReadPath, "Play a camera path", "Play", false, path, with_one<with<play_path>>, nullptr, Dialog::kPath},
    {Dialog::kSavePath, "Save the camera path", "Save", false, new_path, with_one<with<save_path>>, nullptr,
     Dialog::kPath},
    {Dialog::kFrames, "Folder for the frames", "Write frames", false, frames_folder, with_one<write_sized_frames>},
    {Dialog::kReadViews, "Load views", "Load", false, views, with_one<with<load_views>>},
    {Dialog::kSaveViews, "Save all views", "Save", false, new_views, with_one<with<save_views>>},
    {Dialog::kExportModel, "Export the model", "Export", true, new_model, with_one<export_model>, export_model_options},
    {Dialog::kExportSelection, "Export the selection", "Export", true, new_selection, with_one<export_selection>,
     export_selection_options},
    {Dialog::kSaveSession, "Save the session", "Save", true, new_session, with_one<save_session>},
    {Dialog::kAppend, "Append files", "Append", true, more_models, append_models, open_options},
    {Dialog::kSaveAndQuit, "Save all views and quit", "Save and quit", false, new_views, with_one<save_and_quit>},
};

}  // namespace

const FileQuestion* file_question(Dialog dialog) {
  for (const FileQuestion& question : kQuestions)
    if (question.dialog == dialog) return &question;
  return nullptr;
}

}  // namespace sightline::apps
