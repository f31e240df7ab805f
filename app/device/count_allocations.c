/* Counts what a thread allocates while it asks for that. `tandem devices --try` loads this library before all others, so that the author
 * of a driver sees whether the loop allocates. glibc's own entry points do the work. */
#include <errno.h>
#include <stddef.h>

extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* old, size_t size);
extern void* __libc_memalign(size_t alignment, size_t size);

static __thread int armed __attribute__((tls_model("initial-exec")));
static __thread long allocations __attribute__((tls_model("initial-exec")));

#define SHOWN __attribute__((visibility("default")))

/* Starts a new count in this thread, or ends it. */
SHOWN void tandem_count_allocations(int on) {
  armed = on;
  if (on) allocations = 0;
}
SHOWN long tandem_allocations(void) { return allocations; }

SHOWN void* malloc(size_t size) {
  allocations += armed;
  return __libc_malloc(size);
}
SHOWN void* calloc(size_t count, size_t size) {
  allocations += armed;
  return __libc_calloc(count, size);
}
SHOWN void* realloc(void* old, size_t size) {
  allocations += armed;
  return __libc_realloc(old, size);
}
SHOWN void* aligned_alloc(size_t alignment, size_t size) {
  allocations += armed;
  return __libc_memalign(alignment, size);
}
SHOWN int posix_memalign(void** block, size_t alignment, size_t size) {
  allocations += armed;
  *block = __libc_memalign(alignment, size);
  return *block != NULL ? 0 : ENOMEM;
}
