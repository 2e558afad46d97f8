// Catches exceptions in modules with threads, where Emscripten's runtime does not: clang 14 writes where it landed into
// one __wasm_lpad_context for all threads, but Emscripten 3.1.6 reads it from one of each thread, in which nothing was
// written. Names and tasks are those of clang's code for WebAssembly and of the Itanium C++ ABI, level I, whose header
// has other integers in clang's folder than in Emscripten's.
//
// Two threads must not land at the same moment. Exceptions are thrown for want of memory and of threads alone, and by
// the calling thread: the library's jobs catch none.
#include <cstdint>

extern "C" {

struct UnwindException {
  std::uint64_t kind;
  void (*cleanup)(int reason, UnwindException* exception);
};
struct LandingPad {
  std::uintptr_t index, table;  // which of the function's landing pads, and the function's table of what it catches
  std::uintptr_t selector;      // the personality's answer: the clause that catches
};
LandingPad __wasm_lpad_context;  // NOLINT: the compiler's name

constexpr int kForeignExceptionCaught = 1, kCleanupPhase = 2;

int __gxx_personality_wasm0(int version, int actions, std::uint64_t kind, UnwindException* exception,
                            LandingPad* context);

/// Called where an exception lands, by the compiler's code.
int _Unwind_CallPersonality(UnwindException* exception) {
  __wasm_lpad_context.selector = 0;
  return __gxx_personality_wasm0(1, kCleanupPhase, exception->kind, exception, &__wasm_lpad_context);
}

int _Unwind_RaiseException(UnwindException* exception) {
  __builtin_wasm_throw(0, exception);
}
void _Unwind_DeleteException(UnwindException* exception) {
  if (exception->cleanup != nullptr) exception->cleanup(kForeignExceptionCaught, exception);
}

// The personality's view of a landing pad. It takes one from the first, which it thinks is a return address, and counts
// from 1.
std::uintptr_t _Unwind_GetIP(LandingPad* context) {
  return context->index + 2;
}
std::uintptr_t _Unwind_GetLanguageSpecificData(LandingPad* context) {
  return context->table;
}
std::uintptr_t _Unwind_GetRegionStart(LandingPad*) {
  return 0;
}
void _Unwind_SetGR(LandingPad* context, int number, std::uintptr_t value) {
  if (number == 1) context->selector = value;
}
void _Unwind_SetIP(LandingPad*, std::uintptr_t) {}

}  // extern "C"
