#include "sightline/gl/internal/timer.h"

#include <utility>

namespace sightline::gl {

GpuTimer::GpuTimer(const Functions& gl) : gl_(&gl) {
  if (gl.workarounds[Workaround::kNoTimer]) return;
  gl.CreateQueries(GL_TIMESTAMP, static_cast<GLsizei>(queries_.size()), queries_.data());
}

GpuTimer::GpuTimer(GpuTimer&& other) noexcept
    : gl_(other.gl_),
      queries_(std::exchange(other.queries_, {})),
      first_(std::exchange(other.first_, 0)),
      count_(std::exchange(other.count_, 0)),
      open_(std::exchange(other.open_, false)) {}

GpuTimer& GpuTimer::operator=(GpuTimer&& other) noexcept {
  GpuTimer taken(std::move(other));
  std::swap(gl_, taken.gl_);
  std::swap(queries_, taken.queries_);
  std::swap(first_, taken.first_);
  std::swap(count_, taken.count_);
  std::swap(open_, taken.open_);
  return *this;
}

GpuTimer::~GpuTimer() {
  if (queries_[0]) gl_->DeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
}

bool GpuTimer::begin() {
  open_ = queries_[0] != 0 && count_ < kSlots;
  if (open_) gl_->QueryCounter(queries_[2 * ((first_ + count_) % kSlots)], GL_TIMESTAMP);
  return open_;
}

void GpuTimer::end() {
  if (!open_) return;
  gl_->QueryCounter(queries_[2 * ((first_ + count_) % kSlots) + 1], GL_TIMESTAMP);
  ++count_;
  open_ = false;
}

std::optional<double> GpuTimer::poll() {
  if (count_ == 0) return std::nullopt;
  const GLuint begin = queries_[2 * first_];
  const GLuint end = queries_[2 * first_ + 1];
  // Queries finish in order: when the end is available, so is the begin.
  GLuint available = GL_FALSE;
  gl_->BindBuffer(GL_QUERY_BUFFER, 0);  // an application's buffer would take the result
  gl_->GetQueryObjectuiv(end, GL_QUERY_RESULT_AVAILABLE, &available);
  if (!available) return std::nullopt;
  GLuint64 begin_ns = 0;
  GLuint64 end_ns = 0;
  gl_->GetQueryObjectui64v(begin, GL_QUERY_RESULT, &begin_ns);
  gl_->GetQueryObjectui64v(end, GL_QUERY_RESULT, &end_ns);
  first_ = (first_ + 1) % kSlots;
  --count_;
  return end_ns > begin_ns ? static_cast<double>(end_ns - begin_ns) * 1e-6 : kNoTime;
}

}  // namespace sightline::gl
