#include "sightline/bindings/c/internal/call.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

#include "sightline/bindings/c/internal/objects.h"

namespace sightline::capi {
namespace {

/// The last error of this thread. Its size is fixed, so that setting it cannot fail and threads need not free it.
thread_local char last_error[1024] = "";

void set_last_error(std::string_view function, std::string_view message) {
  char* end = last_error;
  for (const std::string_view part : {function, std::string_view(function.empty() ? "" : ": "), message}) {
    const std::size_t room = std::size_t(last_error + sizeof last_error - 1 - end);
    end = std::copy_n(part.data(), std::min(part.size(), room), end);
  }
  *end = '\0';
}

}  // namespace

void refuse(sl_status status, std::string message) {
  throw Failure{status, std::move(message), true};
}

sl_status fail_call(const char* function) noexcept {
  try {
    throw;
  } catch (const Failure& failure) {
    forget_interrupted();
    set_last_error(failure.by_caller ? function : "", failure.message);
    return failure.status;
  } catch (const std::bad_alloc&) {
    break_interrupted();
    set_last_error(function, "out of memory");
    return SL_ERROR_MEMORY;
  } catch (const std::length_error&) {
    break_interrupted();
    set_last_error(function, "out of memory");
    return SL_ERROR_MEMORY;
  } catch (const std::exception& error) {
    break_interrupted();
    set_last_error(function, error.what());
    return SL_ERROR_FAILED;
  } catch (...) {
    break_interrupted();
    set_last_error(function, "unknown exception");
    return SL_ERROR_FAILED;
  }
}

}  // namespace sightline::capi

const char* sl_last_error(void) {
  return sightline::capi::last_error;
}
