// Threads that wait for work, and are asked to stop meanwhile. Internal.
#pragma once

#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>

namespace sightline::core {

/// Waits until `done()`, or until the thread shall stop; whether done(). As condition_variable_any's, which is not
/// used: with g++ 12 for Windows a wake-up of the semaphore within may get lost, and then the thread waits for ever.
template <class Done>
bool wait_until(std::condition_variable& changed, std::unique_lock<std::mutex>& held, const std::stop_token& stop,
                const Done& done) {
  changed.wait(held, [&] { return stop.stop_requested() || done(); });
  return done();
}

/// Asks a thread that may wait so to stop, and wakes it.
inline void request_stop(std::jthread& thread, std::mutex& mutex, std::condition_variable& changed) {
  {
    const std::lock_guard held(mutex);
    thread.request_stop();
  }
  changed.notify_all();
}

}  // namespace sightline::core
