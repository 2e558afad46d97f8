// What mouse and keys do in the image.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sightline/apps/view/axis_triad.h"
#include "sightline/apps/view/events.h"
#include "sightline/apps/view/section_handles.h"
#include "sightline/apps/view/walking.h"

namespace sightline::apps {

struct Workspace;

class Gestures {
 public:
  struct Drag {
    int button = 0, mods = 0;
    core::dvec2 from{0.0}, last{0.0};  // places of the window
    core::dvec3 point{0.0};            // of the model, under the cursor where it began
    bool moves = false;                // farther than a click may
    bool slides = false;               // the slider of a comparison
  };

  explicit Gestures(Workspace& work) : work_(work) {}

  void handle(const Event& event);
  /// Moves the camera by what is held. `seconds`: since the last call.
  void fly(double seconds);
  /// Finds what is under the resting cursor, also while keys move the camera.
  void hover();
  /// Ends drags and held keys, whose ends may be elsewhere.
  void let_go();
  /// Another model is there.
  void forget_model();
  /// Ends one thing: the topmost menu, else the dialog, a camera path, the tool, walking, or at last the selection.
  void escape();
  bool walking() const { return walker_.has_value(); }
  /// Motion stays on the floor, and walls stop it; or the camera flies again.
  void set_walking(bool walking);
  /// The camera moves by itself or by what is held.
  bool moves() const;
  bool drags() const { return drag_.has_value(); }
  /// The pointer has moved or clicked, and what is below it is not known yet.
  bool waits_for_picks() const;

  const core::dvec2& cursor() const { return cursor_; }
  /// What the image shows under the cursor, or at a point of the window.
  core::Expected<std::optional<engine::Pick>> under_cursor() { return under(cursor_); }
  core::Expected<std::optional<engine::Pick>> under(const core::dvec2& at);
  const std::optional<engine::Pick>& context_face() const { return context_face_; }  ///< below the context menu
  /// The point of the model that the resting cursor is over.
  const std::optional<core::dvec3>& cursor_point() const { return cursor_point_; }
  /// What a click would mark.
  const std::optional<measure::Snap>& aimed() const { return aimed_; }
  /// The axes in the image's corner; none beside hidden panels or in a small image.
  std::optional<AxisTriad> triad() const;
  std::optional<AxisTriad::End> triad_end() const;  ///< under the cursor
  /// Handles of sections show beside panels.
  bool shows_section_handles() const;
  const SectionHandles& section_handles() const { return section_handles_; }
  std::optional<SectionHandles::Target> section_target() const;  ///< dragged, or else under the cursor
  bool over_slider() const;                                      ///< a press would drag it, or does
  const std::optional<Drag>& drag() const { return drag_; }      ///< that goes on

 private:
  void drop(const std::vector<std::string>& files);
  void press_key(const Event& event);
  void press_button(const Event& event);
  void release_button(const Event& event);
  void move_cursor(const core::dvec2& to);
  void click(const Drag& drag);
  void open_context_menu(const core::dvec2& at);
  void set_mark(const core::dvec2& at);
  void select_rectangle(const Drag& drag);
  void walk(const core::dvec3& held, double seconds);

  Workspace& work_;
  std::set<int> held_;  // keys
  std::optional<Walker> walker_;
  std::optional<Drag> drag_, click_;  // the second until picks do not wait
  SectionHandles section_handles_;    // while one is dragged, drag_ is that motion
  double last_click_ = -1.0;          // GLFW's time, of one without modifiers
  core::dvec2 last_click_at_{0.0};
  core::dvec2 cursor_{-1.0};
  bool cursor_moved_ = false;
  std::optional<engine::Pick> context_face_;
  std::optional<core::dvec3> cursor_point_;
  std::optional<measure::Snap> aimed_;
  // When the item under the cursor was last looked for: the document's version, and the camera.
  std::uint64_t hovered_version_ = 0;
  std::optional<core::View> hovered_view_;
};

}  // namespace sightline::apps
