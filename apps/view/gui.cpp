#include "sightline/apps/view/gui.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <imgui_internal.h>  // for the stack of popups, which Esc closes one by one

namespace sightline::apps {
namespace {

constexpr int kHighScreen = 1800;  // pixels; a window that high is on a 4K screen, whatever the display says
constexpr const char* kFonts[] = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                  "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                  "/usr/share/fonts/TTF/DejaVuSans.ttf"};

constexpr std::pair<ImGuiKey, int> kKeys[] = {{ImGuiKey_Tab, GLFW_KEY_TAB},
                                              {ImGuiKey_LeftArrow, GLFW_KEY_LEFT},
                                              {ImGuiKey_RightArrow, GLFW_KEY_RIGHT},
                                              {ImGuiKey_UpArrow, GLFW_KEY_UP},
                                              {ImGuiKey_DownArrow, GLFW_KEY_DOWN},
                                              {ImGuiKey_PageUp, GLFW_KEY_PAGE_UP},
                                              {ImGuiKey_PageDown, GLFW_KEY_PAGE_DOWN},
                                              {ImGuiKey_Home, GLFW_KEY_HOME},
                                              {ImGuiKey_End, GLFW_KEY_END},
                                              {ImGuiKey_Insert, GLFW_KEY_INSERT},
                                              {ImGuiKey_Delete, GLFW_KEY_DELETE},
                                              {ImGuiKey_Backspace, GLFW_KEY_BACKSPACE},
                                              {ImGuiKey_Space, GLFW_KEY_SPACE},
                                              {ImGuiKey_Enter, GLFW_KEY_ENTER},
                                              {ImGuiKey_Escape, GLFW_KEY_ESCAPE},
                                              {ImGuiKey_KeyPadEnter, GLFW_KEY_KP_ENTER},
                                              {ImGuiKey_A, GLFW_KEY_A},
                                              {ImGuiKey_C, GLFW_KEY_C},
                                              {ImGuiKey_V, GLFW_KEY_V},
                                              {ImGuiKey_X, GLFW_KEY_X},
                                              {ImGuiKey_Y, GLFW_KEY_Y},
                                              {ImGuiKey_Z, GLFW_KEY_Z}};

void feed(ImGuiIO& io, const Event& event) {
  const auto modifiers = [&] {
    io.KeyCtrl = (event.mods & GLFW_MOD_CONTROL) != 0;
    io.KeyShift = (event.mods & GLFW_MOD_SHIFT) != 0;
    io.KeyAlt = (event.mods & GLFW_MOD_ALT) != 0;
  };
  switch (event.type) {
    case Event::Type::kKey:
      modifiers();
      // Window systems disagree on whether the event of a modifier counts that modifier.
      if (event.key == GLFW_KEY_LEFT_CONTROL || event.key == GLFW_KEY_RIGHT_CONTROL) io.KeyCtrl = event.down;
      if (event.key == GLFW_KEY_LEFT_SHIFT || event.key == GLFW_KEY_RIGHT_SHIFT) io.KeyShift = event.down;
      if (event.key == GLFW_KEY_LEFT_ALT || event.key == GLFW_KEY_RIGHT_ALT) io.KeyAlt = event.down;
      if (event.key >= 0 && event.key < IM_ARRAYSIZE(io.KeysDown)) io.KeysDown[event.key] = event.down;
      break;
    case Event::Type::kText:
      io.AddInputCharactersUTF8(event.text.c_str());
      break;
    case Event::Type::kButton:
      modifiers();
      if (event.key < IM_ARRAYSIZE(io.MouseDown)) io.MouseDown[event.key] = event.down;
      io.MousePos = {float(event.at.x), float(event.at.y)};
      break;
    case Event::Type::kCursor:
      io.MousePos = {float(event.at.x), float(event.at.y)};
      break;
    case Event::Type::kWheel:
      io.MouseWheel += float(event.wheel);
      break;
    case Event::Type::kDrop:
    case Event::Type::kExpose:
      break;
  }
}

void set_style(Theme theme, double scale) {
  ImGuiStyle style;
  theme == Theme::kDark ? ImGui::StyleColorsDark(&style) : ImGui::StyleColorsLight(&style);
  style.WindowRounding = 0.0f;
  style.FrameRounding = 3.0f;
  style.WindowBorderSize = 1.0f;
  for (const int ground : {ImGuiCol_WindowBg, ImGuiCol_PopupBg})
    style.Colors[ground].w = 1.0f;  // text on lines is hard to read
  style.ScaleAllSizes(float(scale));
  ImGui::GetStyle() = style;
}

}  // namespace

core::Expected<Gui> Gui::create(Window& window, Theme theme, double scale) {
  IMGUI_CHECKVERSION();
  Gui gui(ImGui::CreateContext());
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // panels stay where they are put
  io.BackendFlags |= ImGuiBackendFlags_HasMouseCursors;
  for (const auto& [key, glfw] : kKeys) io.KeyMap[key] = glfw;
  io.ClipboardUserData = &window;
  io.SetClipboardTextFn = [](void* user, const char* text) { static_cast<Window*>(user)->set_clipboard(text); };
  io.GetClipboardTextFn = [](void* user) {
    static std::string text;  // ImGui reads it at once
    text = static_cast<Window*>(user)->clipboard();
    return text.c_str();
  };
  gui.scale_ = scale > 0.0 ? scale : std::max(window.scale(), window.size()[1] >= kHighScreen ? 2.0 : 1.0);
  gui.load_font();
  gui.set_theme(theme);
  if (auto done = gui.use_context(); !done) return tl::unexpected(done.error());
  return gui;
}

void Gui::drop_context() {
  if (ImGui::GetIO().BackendRendererUserData) ImGui_ImplOpenGL3_Shutdown();
}

core::Expected<void> Gui::use_context() {
  if (!ImGui_ImplOpenGL3_Init("#version 450")) return core::fail("the user interface cannot draw in this context");
  return {};
}

void Gui::Destroy::operator()(ImGuiContext* context) const {
  if (ImGui::GetIO().BackendRendererUserData) ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext(context);
}

Gui::~Gui() = default;

ImFont* add_font(ImFontAtlas& atlas, float pixels) {
  ImFontConfig config;
  config.OversampleH = 2;
  static const ImWchar ranges[] = {0x20,   0x24f,  0x370,  0x3ff,  0x400,  0x45f,  0x2010, 0x2044,
                                   0x2190, 0x21ff, 0x2200, 0x22ff, 0x25a0, 0x25ff, 0};
  for (const char* file : kFonts) {
    std::error_code none;
    if (!std::filesystem::exists(file, none)) continue;
    if (ImFont* font = atlas.AddFontFromFileTTF(file, pixels, &config, ranges)) return font;
  }
  return atlas.AddFontDefault();
}

void Gui::load_font() {
  const float pixels = float(kFontPixels * scale_);
  add_font(*ImGui::GetIO().Fonts, pixels);
  if (ImGui::GetIO().Fonts->ConfigData.back().SizePixels != pixels) ImGui::GetIO().FontGlobalScale = float(scale_);
}

void Gui::set_theme(Theme theme) {
  set_style(theme, scale_);
}

void Gui::push(std::vector<Event> events) {
  for (Event& event : events) waiting_.push_back(std::move(event));
}

std::vector<Event> Gui::take_events() {
  std::vector<Event> events;
  for (; !waiting_.empty(); waiting_.pop_front()) {
    const Event& next = waiting_.front();
    const bool press = next.type == Event::Type::kKey || next.type == Event::Type::kButton;
    const auto clashes = [&](const Event& before) {
      const bool cursor = before.type == Event::Type::kCursor, pressed = before.type == Event::Type::kButton;
      if ((cursor && next.type == Event::Type::kButton) || (pressed && next.type == Event::Type::kCursor)) return true;
      return press && before.type == next.type && before.key == next.key;
    };
    if (std::any_of(events.begin(), events.end(), clashes)) break;
    feed(ImGui::GetIO(), next);
    events.push_back(next);
  }
  return events;
}

bool Gui::uses(const Event& event) const {
  const ImGuiIO& io = ImGui::GetIO();
  const bool key = event.type == Event::Type::kKey || event.type == Event::Type::kText;
  return key ? io.WantCaptureKeyboard : event.type != Event::Type::kDrop && io.WantCaptureMouse;
}

bool Gui::has_text_cursor() const {
  return ImGui::GetIO().WantTextInput;
}

bool Gui::has_popup() const {
  return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);
}

bool Gui::close_popup() {
  const int open = ImGui::GetCurrentContext()->OpenPopupStack.Size;
  if (open > 0) ImGui::ClosePopupToLevel(open - 1, true);
  return open > 0;
}

void Gui::begin(const std::array<int, 2>& size, double seconds) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {float(size[0]), float(size[1])};
  io.DeltaTime = std::max(1e-4f, float(seconds));
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

void Gui::end() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace sightline::apps
