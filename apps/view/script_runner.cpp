#include "sightline/apps/view/script_runner.h"

#include <algorithm>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {
namespace {

Done expect(const std::string& argument, const Workspace& work) {
  const std::size_t space = argument.find(' ');
  const std::string pointer = argument.substr(0, space),
                    demand = space == std::string::npos ? "" : argument.substr(space + 1);
  const json::Value all = state_json(work);
  const json::Value* value = all.find_pointer(pointer);
  if (!value) return core::fail("expect: the state has no " + pointer);
  const auto good = fulfils(value->dump(), demand);
  if (!good) return tl::unexpected(good.error());
  if (!*good) return core::fail("expected " + argument + ", found " + value->dump());
  return {};
}

}  // namespace

Done ScriptRunner::read(const std::string& file) {
  if (file.empty()) return {};
  auto steps = read_script(file);
  if (!steps) return tl::unexpected(steps.error());
  file_ = file;
  steps_ = std::move(*steps);
  return {};
}

bool ScriptRunner::waits() const {
  return !window_shot_.empty() || glfwGetTime() < wait_until_;
}

bool ScriptRunner::ended() const {
  return !steps_.empty() && !has_steps() && !waits();
}

void ScriptRunner::follow(Workspace& work) {
  if (release_ && glfwGetTime() >= wait_until_) work.gui.push({*std::exchange(release_, std::nullopt)});
}

Done ScriptRunner::step(Workspace& work) {
  const ScriptStep& step = steps_[next_];
  const bool at_point =
      step.name == "wheel" || step.name == "drag" || step.name == "mark";  // of the model, where picks do not wait
  if (at_point && work.session && work.session->engine.preparing_picks()) return {};
  ++next_;
  if (auto done = carry_out(step, work); !done)
    return core::fail(file_ + ":" + std::to_string(step.line) + ": " + done.error().message);
  work.pace.redraw();
  return {};
}

Done ScriptRunner::carry_out(const ScriptStep& step, Workspace& work) {
  auto events = events_of(step);
  if (!events) return tl::unexpected(events.error());
  if (!events->empty()) {
    if (step.name == "wheel") events->front().at = work.gestures.cursor();
    work.gui.push(std::move(*events));
    return {};
  }
  if (step.name == "expect") return expect(step.argument, work);
  if (step.name == "window-shot") return window_shot_ = step.argument, Done();
  if (step.name == "hold") return hold(step, work);
  if (step.name == "resize") {
    const auto size = parse_size(step.argument);
    if (!size) return tl::unexpected(size.error());
    work.window.resize(*size);
    wait_until_ = glfwGetTime() + 0.2;  // the window system answers later
    return {};
  }
  if (step.name == "wait") {
    const auto seconds = parse_finite(step.argument);
    if (!seconds) return tl::unexpected(seconds.error());
    wait_until_ = glfwGetTime() + *seconds;
    return {};
  }
  if (step.name == "menu") {
    const std::size_t colon = std::min(step.argument.find(": "), step.argument.size());
    const Command* command = find_in_menus(step.argument.substr(0, colon));
    if (!command) return core::fail("no menu " + step.argument);
    return carry_out({step.line, command->name, step.argument.substr(std::min(colon + 2, step.argument.size()))}, work);
  }
  const Command* command = find_command(step.name);
  if (!command) return core::fail("no command " + step.name);
  if (command->needs_model() && !work.session) return core::fail(step.name + ": no model is open");
  auto done = command->run(work, step.argument);
  work.messages.tell_outcome(done);
  return done;
}

Done ScriptRunner::hold(const ScriptStep& step, Workspace& work) {
  const std::size_t space = step.argument.rfind(' ');
  const auto seconds = parse_finite(space == std::string::npos ? "" : step.argument.substr(space + 1));
  if (!seconds) return core::fail("hold: expected a key and seconds, found \"" + step.argument + "\"");
  auto pressed = events_of({step.line, "press", step.argument.substr(0, space)});
  if (!pressed) return tl::unexpected(pressed.error());
  release_ = pressed->back();
  work.gui.push({pressed->front()});
  wait_until_ = glfwGetTime() + *seconds;
  return {};
}

}  // namespace sightline::apps
