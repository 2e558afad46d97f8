// The handles of all sections in the image, and the one that is being dragged.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/view/section_gizmo.h"
#include "sightline/apps/view/session.h"

namespace sightline::apps {

class SectionHandles {
 public:
  struct Shown {
    std::size_t section;
    SectionGizmo gizmo;
  };
  struct Target {
    std::size_t section;
    SectionGizmo::Part part;
  };
  /// Sections stop at round distances from the model's origin and turn by 15 degrees; or they stop at the feature of
  /// the model that is next to the cursor.
  struct Snapping {
    bool round = false, model = false;
  };

  /// Handles of all sections that are on; the one to draw first comes first, the selected one last and whole.
  static std::vector<Shown> shown(const Session& session, double scale);
  /// The handle at a point of the image.
  static std::optional<Target> at(const Session& session, const core::dvec2& at, double scale);

  /// Begins to drag what is at a point, and selects its section. False where no handle is.
  bool press(Session& session, const core::dvec2& at, double scale);
  void drag(Session& session, const core::dvec2& to, const Snapping& snapping);
  /// Ends that. A `click`, on the middle of the section that was selected before, flips it.
  void release(Session& session, bool click);
  /// Ends that, and puts the section back to where it was.
  void cancel(Session& session);
  void forget() { drag_.reset(); }

  bool dragging() const { return drag_.has_value(); }
  std::optional<Target> dragged() const { return drag_ ? std::optional(drag_->target) : std::nullopt; }
  /// How far it was dragged.
  std::string words(const LengthFormat& lengths) const;

 private:
  struct Drag {
    Target target;
    SectionGizmo gizmo;
    Sections::Section before;
    core::dvec2 from;
    bool was_selected = false;
    double by = 0.0;
    core::dvec3 place;  // of the section now, in the model's own frame
  };
  Sections::Section* section(Session& session) const;
  double snapped(Session& session, double by, const core::dvec2& to, const Snapping& snapping) const;

  std::optional<Drag> drag_;
};

}  // namespace sightline::apps
