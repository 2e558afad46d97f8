// The dialog that asks for files, whatever they are for.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "sightline/apps/view/file_browser.h"
#include "sightline/importers/json/internal/json.h"

struct ImGuiInputTextCallbackData;

namespace sightline::apps {

struct Workspace;
struct FileQuestion;

class FileDialog {
 public:
  /// Draws it, if the viewer's dialog is one that asks for files.
  void draw(Workspace& work);
  /// The part of the viewer's state about the dialog; null while nothing is asked.
  json::Value state() const;

 private:
  void begin(Workspace& work);
  void breadcrumb();
  void place_list(float width, float height);
  void list(float height);
  void rows(float height);
  void name_field();
  void keys();
  void take_name(ImGuiInputTextCallbackData& field);
  void replace_question(Workspace& work);
  void accept(Workspace& work);
  void answer(Workspace& work, const std::vector<std::filesystem::path>& files);
  std::filesystem::path& last_folder();

  const FileQuestion* question_ = nullptr;  // null: the dialog is closed
  FileBrowser browser_;
  std::vector<Place> places_;
  std::array<std::filesystem::path, 2> last_folders_;  // of answers: of models, of other files
  double refresh_at_ = 0.0;
  std::string field_;  // as the field of the name has it
  bool field_active_ = false, field_all_selected_ = false, scrolls_ = false, accepts_ = false;
  int page_ = 1;  // rows of the list that are seen
};

}  // namespace sightline::apps
