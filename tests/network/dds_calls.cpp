#include "tests/network/dds_calls.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <set>
#include <stdexcept>

#include <dds/dds.h>
#undef restrict
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsrt/heap.h>
#include <dds/ddsrt/string.h>
#include <dlfcn.h>
#include <link.h>
#include <sys/mman.h>
#include <unistd.h>

extern "C" {
// declared in Cyclone's own headers, which C++ does not take
bool ddsi_typeid_is_hash(const ddsi_typeid* type);
const ddsi_typeid* ddsi_typeinfo_minimal_typeid(const ddsi_typeinfo* info);
const ddsi_typeid* ddsi_typeinfo_complete_typeid(const ddsi_typeinfo* info);
struct dds_reader;
struct ddsi_tkmap;
struct ddsi_tkmap_instance;
ddsi_tkmap_instance* ddsi_tkmap_find(ddsi_tkmap* map, ddsi_serdata* sample, bool create);
dds_rhc* dds_rhc_default_new(dds_reader* reader, const ddsi_sertype* type);
}

namespace tandem::testing {

namespace {

#define TANDEM_DDS_FUNCTIONS(X)          \
  X(dds_builtintopic_free_endpoint)      \
  X(dds_create_domain)                   \
  X(dds_create_guardcondition)           \
  X(dds_create_listener)                 \
  X(dds_create_participant)              \
  X(dds_create_qos)                      \
  X(dds_create_readcondition)            \
  X(dds_create_reader)                   \
  X(dds_create_reader_rhc)               \
  X(dds_create_topic)                    \
  X(dds_create_waitset)                  \
  X(dds_create_writer)                   \
  X(dds_delete)                          \
  X(dds_delete_listener)                 \
  X(dds_delete_qos)                      \
  X(dds_dispose)                         \
  X(dds_free)                            \
  X(dds_get_guid)                        \
  X(dds_get_matched_publication_data)    \
  X(dds_get_matched_publications)        \
  X(dds_get_publication_matched_status)  \
  X(dds_get_subscription_matched_status) \
  X(dds_istream_init)                    \
  X(dds_lookup_participant)              \
  X(dds_lset_data_available)             \
  X(dds_lset_liveliness_changed)         \
  X(dds_lset_subscription_matched)       \
  X(dds_ostream_fini)                    \
  X(dds_ostream_init)                    \
  X(dds_qget_partition)                  \
  X(dds_qset_durability)                 \
  X(dds_qset_durability_service)         \
  X(dds_qset_history)                    \
  X(dds_qset_ignorelocal)                \
  X(dds_qset_liveliness)                 \
  X(dds_qset_partition)                  \
  X(dds_qset_prop)                       \
  X(dds_qset_reliability)                \
  X(dds_qset_writer_data_lifecycle)      \
  X(dds_read_guardcondition)             \
  X(dds_register_instance)               \
  X(dds_return_loan)                     \
  X(dds_rhc_default_new)                 \
  X(dds_set_guardcondition)              \
  X(dds_set_log_sink)                    \
  X(dds_sleepfor)                        \
  X(dds_stream_free_sample)              \
  X(dds_stream_normalize_data)           \
  X(dds_stream_read)                     \
  X(dds_stream_write)                    \
  X(dds_strretcode)                      \
  X(dds_take)                            \
  X(dds_take_guardcondition)             \
  X(dds_time)                            \
  X(dds_unregister_instance)             \
  X(dds_wait_for_acks)                   \
  X(dds_waitset_attach)                  \
  X(dds_waitset_wait)                    \
  X(dds_write)                           \
  X(ddsi_tkmap_find)                     \
  X(ddsi_typeid_is_hash)                 \
  X(ddsi_typeinfo_complete_typeid)       \
  X(ddsi_typeinfo_minimal_typeid)        \
  X(ddsrt_calloc)                        \
  X(ddsrt_malloc)                        \
  X(ddsrt_strdup)

enum Function : std::size_t {
#define TANDEM_NUMBER(name) k_##name,
  TANDEM_DDS_FUNCTIONS(TANDEM_NUMBER)
#undef TANDEM_NUMBER
      kFunctions
};

struct Counts {
  std::atomic<long> inside = 0;
  std::atomic<long> outside = 0;
};
std::array<Counts, kFunctions> counts;
std::array<void*, kFunctions> cyclones;  // the functions themselves
thread_local int depth = 0;

template <std::size_t kFunction, typename F>
struct Counted;
template <std::size_t kFunction, typename R, typename... Args>
struct Counted<kFunction, R(Args...)> {
  static R Call(Args... args) {
    Counts& count = counts[kFunction];
    (depth > 0 ? count.inside : count.outside).fetch_add(1);
    return reinterpret_cast<R (*)(Args...)>(cyclones[kFunction])(args...);
  }
};

struct Entry {
  const char* name;
  void* counted;
};
// attributes of functions, such as malloc, are nothing to count by
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wignored-attributes"
const std::array<Entry, kFunctions> kEntries = {{
#define TANDEM_ENTRY(name) \
  {#name, reinterpret_cast<void*>(&Counted<k_##name, decltype(name)>::Call)},
    TANDEM_DDS_FUNCTIONS(TANDEM_ENTRY)
#undef TANDEM_ENTRY
}};
#pragma GCC diagnostic pop

std::uintptr_t Pointer(const dl_phdr_info& program, std::uintptr_t address) {
  // absolute by now, except where the loader leaves the table as it was linked
  return address < program.dlpi_addr ? address + program.dlpi_addr : address;
}

void Write(void** slot, void* value) {
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto address = reinterpret_cast<std::uintptr_t>(slot);
  void* const start = reinterpret_cast<void*>(address / page * page);
  if (mprotect(start, page, PROT_READ | PROT_WRITE) != 0) {
    throw std::runtime_error("cannot write into the program's table of functions");
  }
  *slot = value;
}

/// The first object that is visited is the program itself.
int WatchProgram(dl_phdr_info* program, std::size_t, void* unknown) {
  const ElfW(Dyn)* dynamic = nullptr;
  for (int i = 0; i < program->dlpi_phnum; ++i) {
    if (program->dlpi_phdr[i].p_type != PT_DYNAMIC) continue;
    dynamic =
        reinterpret_cast<const ElfW(Dyn)*>(program->dlpi_addr + program->dlpi_phdr[i].p_vaddr);
  }
  const ElfW(Sym)* symbols = nullptr;
  const char* names = nullptr;
  struct {
    std::uintptr_t at = 0;
    std::size_t bytes = 0;
  } tables[2];
  for (; dynamic != nullptr && dynamic->d_tag != DT_NULL; ++dynamic) {
    const std::uintptr_t value = dynamic->d_un.d_ptr;
    if (dynamic->d_tag == DT_PLTRELSZ) tables[0].bytes = value;
    if (dynamic->d_tag == DT_RELASZ) tables[1].bytes = value;
    if (dynamic->d_tag == DT_JMPREL) tables[0].at = Pointer(*program, value);
    if (dynamic->d_tag == DT_RELA) tables[1].at = Pointer(*program, value);
    if (dynamic->d_tag == DT_SYMTAB) {
      symbols = reinterpret_cast<const ElfW(Sym)*>(Pointer(*program, value));
    }
    if (dynamic->d_tag == DT_STRTAB) {
      names = reinterpret_cast<const char*>(Pointer(*program, value));
    }
  }
  for (const auto& [at, bytes] : tables) {
    const auto* const rows = reinterpret_cast<const ElfW(Rela)*>(at);
    for (std::size_t i = 0; i < bytes / sizeof(ElfW(Rela)); ++i) {
      const ElfW(Sym)& symbol = symbols[ELF64_R_SYM(rows[i].r_info)];
      const char* const name = names + symbol.st_name;
      const bool function = ELF64_ST_TYPE(symbol.st_info) == STT_FUNC;
      if (!function || std::strncmp(name, "dds", 3) != 0 || symbol.st_shndx != SHN_UNDEF) continue;
      std::size_t known = 0;
      while (known < kFunctions && std::strcmp(kEntries[known].name, name) != 0) ++known;
      if (known == kFunctions) {
        static_cast<std::set<std::string>*>(unknown)->insert(name);
        continue;
      }
      cyclones[known] = dlsym(RTLD_DEFAULT, name);
      Write(reinterpret_cast<void**>(program->dlpi_addr + rows[i].r_offset),
            kEntries[known].counted);
    }
  }
  return 1;
}

}  // namespace

std::vector<std::string> WatchDdsCalls() {
  std::set<std::string> unknown;
  dl_iterate_phdr(WatchProgram, &unknown);
  return {unknown.begin(), unknown.end()};
}

DdsCallsInside::DdsCallsInside() {
  ++depth;
}

DdsCallsInside::~DdsCallsInside() {
  --depth;
}

DdsCalls CountedDdsCalls() {
  DdsCalls calls;
  for (std::size_t i = 0; i < kFunctions; ++i) {
    if (counts[i].inside > 0) calls.inside[kEntries[i].name] = counts[i].inside;
    if (counts[i].outside > 0) calls.outside[kEntries[i].name] = counts[i].outside;
  }
  return calls;
}

}  // namespace tandem::testing
