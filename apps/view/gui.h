// Dear ImGui in the viewer's window: fed with events, so that a script's are as good as the user's.
#pragma once

#include <deque>
#include <memory>

#include "sightline/apps/view/window.h"

struct ImFont;
struct ImFontAtlas;
struct ImGuiContext;

namespace sightline::apps {

enum class Theme { kDark, kLight };

inline constexpr float kFontPixels = 15.0f;  ///< the height of text on a screen of usual density
/// The font of panels, in that height. Without DejaVu it is ImGui's own, which has no accents and is coarse.
ImFont* add_font(ImFontAtlas& atlas, float pixels);

class Gui {
 public:
  /// In the window's context, which must outlive it. One at a time. `scale`: of text and panels; 0: as the screen
  /// suggests.
  static core::Expected<Gui> create(Window& window, Theme theme, double scale = 0.0);
  Gui(Gui&&) = default;
  ~Gui();

  void set_theme(Theme theme);
  double scale() const { return scale_; }

  void push(std::vector<Event> events);
  /// The next frame's events, among which no key or button changes twice, and the cursor is where a button changed:
  /// widgets see each state once. More wait.
  std::vector<Event> take_events();
  bool has_events() const { return !waiting_.empty(); }
  /// Whether widgets use an event, as of the last frame.
  bool uses(const Event& event) const;
  bool has_text_cursor() const;
  bool has_popup() const;  ///< a menu or the like, open
  bool close_popup();      ///< the topmost one; false where none is open

  /// Frees what lies in the window's context, and makes it anew in the context that the window then has. No frame may
  /// be drawn in between.
  void drop_context();
  core::Expected<void> use_context();

  void begin(const std::array<int, 2>& size, double seconds);
  /// Draws the widgets into the back buffer.
  void end();

 private:
  struct Destroy {
    void operator()(ImGuiContext* context) const;
  };
  explicit Gui(ImGuiContext* context) : context_(context) {}
  void load_font();

  std::unique_ptr<ImGuiContext, Destroy> context_;
  double scale_ = 1.0;
  std::deque<Event> waiting_;
};

}  // namespace sightline::apps
