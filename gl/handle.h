// Sole ownership of one GL object name: what the classes of this folder are made of.
#pragma once

#include <utility>

#include "sightline/gl/functions.h"

namespace sightline::gl {

/// Move-only owner of a name; `Delete(gl, name)` frees it. Name 0 is nothing. The table must outlive the handle, and
/// the handle must be destroyed while the table's context is current.
template <void (*Delete)(const Functions&, GLuint)>
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
    if (name_) Delete(*gl_, name_);
  }

  const Functions& gl() const { return *gl_; }  ///< only of a handle that was given a table
  GLuint name() const { return name_; }

 private:
  const Functions* gl_ = nullptr;
  GLuint name_ = 0;
};

}  // namespace sightline::gl
