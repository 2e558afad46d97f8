// A plugin of qemu-user that counts the instructions which a program executes, by function:
//   cc -shared -fPIC -O2 -o count.so scripts/count_instructions.c
//   qemu-aarch64 -plugin ./count.so -d plugin -D COUNTS PROGRAM …
// writes a line "INSTRUCTIONS SYMBOL" for each function of the program into the file COUNTS. Debian has no package with
// the header of plugins, so what is needed of version 1 is declared here.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum { ADD_U64 };
typedef void Translated(qemu_plugin_id_t, struct qemu_plugin_tb*);
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, Translated*);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn*, int, void*, uint64_t);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void*), void*);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb*, size_t);
const char* qemu_plugin_insn_symbol(const struct qemu_plugin_insn*);
void qemu_plugin_outs(const char*);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

enum { kMost = 1 << 16 };  // functions; a power of two
static struct {
  const char* symbol;
  uint64_t count;
} g_functions[kMost];

static uint64_t* count_of(const char* symbol) {
  uint64_t hash = 14695981039346656037u;
  for (const char* c = symbol; *c; ++c) hash = (hash ^ (unsigned char)*c) * 1099511628211u;
  size_t at = hash % kMost;
  while (g_functions[at].symbol && strcmp(g_functions[at].symbol, symbol) != 0) at = (at + 1) % kMost;
  if (!g_functions[at].symbol) g_functions[at].symbol = strdup(symbol);
  return &g_functions[at].count;
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); ++i) {
    struct qemu_plugin_insn* const instruction = qemu_plugin_tb_get_insn(block, i);
    const char* const symbol = qemu_plugin_insn_symbol(instruction);
    qemu_plugin_register_vcpu_insn_exec_inline(instruction, ADD_U64, count_of(symbol ? symbol : "?"), 1);
  }
}

static void ended(qemu_plugin_id_t id, void* unused) {
  (void)id, (void)unused;
  for (size_t at = 0; at < kMost; ++at) {
    if (g_functions[at].count == 0) continue;
    char count[32];
    snprintf(count, sizeof count, "%" PRIu64 " ", g_functions[at].count);
    qemu_plugin_outs(count), qemu_plugin_outs(g_functions[at].symbol), qemu_plugin_outs("\n");
  }
}

__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id, const void* info, int argc,
                                                               char** argv) {
  (void)info, (void)argc, (void)argv;
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, ended, NULL);
  return 0;
}
