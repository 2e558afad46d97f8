// Sole ownership of one GL object name. The classes of this folder are built on it.
#pragma once

#include <initializer_list>
#include <string_view>
#include <type_traits>
#include <utility>

#include "sightline/core/error.h"
#include "sightline/gl/functions.h"

namespace sightline::gl {

/// Move-only owner of a name that the entry point `Delete` frees, such as &Functions::DeleteBuffers. Name 0 is nothing.
/// The table must outlive the handle, and the handle must be destroyed while the table's context is current.
template <auto Delete>
class Handle {
 public:
  Handle() = default;
  Handle(const Functions& gl, GLuint name) : gl_(&gl), name_(name) {}
  Handle(Handle&& other) noexcept : gl_(other.gl_), name_(std::exchange(other.name_, 0)) {}
  Handle& operator=(Handle&& other) noexcept {
    Handle old(std::move(*this));  // freed on return
    gl_ = other.gl_;
    name_ = std::exchange(other.name_, 0);
    return *this;
  }
  ~Handle() {
    if (!name_) return;
    if constexpr (std::is_invocable_v<decltype(gl_->*Delete), GLuint>) {
      (gl_->*Delete)(name_);
    } else {
      (gl_->*Delete)(1, &name_);
    }
  }

  const Functions& gl() const { return *gl_; }  ///< only for a handle that was given a table
  GLuint name() const { return name_; }

 private:
  const Functions* gl_ = nullptr;
  GLuint name_ = 0;
};

/// Makes one name with an entry point such as &Functions::CreateVertexArrays. `target`: for entry points that take one.
/// 0 where the driver has no memory: see check_names().
template <auto Create, class... Target>
GLuint create_name(const Functions& gl, Target... target) {
  GLuint name = 0;
  (gl.*Create)(target..., 1, &name);
  return name;
}

/// Fails with GL's error if one of the names is 0. What is bound or drawn with name 0 would be lost without a word, or
/// go to the application's window. `what` names the objects.
SIGHTLINE_API core::Expected<void> check_names(const Functions& gl, std::initializer_list<GLuint> names,
                                               std::string_view what);

}  // namespace sightline::gl
