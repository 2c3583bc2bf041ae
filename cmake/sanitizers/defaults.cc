// The sanitizers' options, compiled into every program of a sanitized build so that they hold however it is started.
// The environment (ASAN_OPTIONS, UBSAN_OPTIONS, LSAN_OPTIONS) still overrides them.

extern "C" {

const char* __asan_default_options() { return "detect_stack_use_after_return=1:strict_string_checks=1"; }

const char* __ubsan_default_options() { return "print_stacktrace=1"; }

const char* __lsan_default_options() { return "print_suppressions=0"; }

// What Debian's libraries keep until the process ends. Nothing of ours belongs here.
const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\n"   // Mesa keeps its screen after the last context is gone
         "leak:libassimp\n";  // assimp loses what it had read of a file that it then refuses
}

}  // extern "C"
