/* An access-control plug-in that says yes to whatever its own program asks for, as an attacker's
 * would; all else is Debian's. It is loaded by rogue_peer.cpp in place of that. */
#include <dds/security/dds_security_api.h>
#include <dlfcn.h>
#include <stddef.h>

static DDS_Security_boolean AllowWriter(dds_security_access_control* instance,
                                        const DDS_Security_PermissionsHandle permissions,
                                        const DDS_Security_DomainId domain,
                                        const DDS_Security_char* topic, const DDS_Security_Qos* qos,
                                        const DDS_Security_PartitionQosPolicy* partition,
                                        const DDS_Security_DataTags* tags,
                                        DDS_Security_SecurityException* exception) {
  (void)instance, (void)permissions, (void)domain, (void)topic, (void)qos, (void)partition;
  (void)tags, (void)exception;
  return 1;
}

static DDS_Security_boolean AllowTopic(dds_security_access_control* instance,
                                       const DDS_Security_PermissionsHandle permissions,
                                       const DDS_Security_DomainId domain,
                                       const DDS_Security_char* topic, const DDS_Security_Qos* qos,
                                       DDS_Security_SecurityException* exception) {
  (void)instance, (void)permissions, (void)domain, (void)topic, (void)qos, (void)exception;
  return 1;
}

typedef int Init(const char* argument, void** context, struct ddsi_domaingv* gv);
typedef int Finalize(void* context);

static void* Library(void) {
  return dlopen(TANDEM_REAL_ACCESS_CONTROL, RTLD_NOW);
}

int init_access_control(const char* argument, void** context, struct ddsi_domaingv* gv);
int init_access_control(const char* argument, void** context, struct ddsi_domaingv* gv) {
  void* library = Library();
  Init* real = library != NULL ? (Init*)dlsym(library, "init_access_control") : NULL;
  const int result = real != NULL ? real(argument, context, gv) : -1;
  if (result == 0) {
    dds_security_access_control* plugin = *context;
    plugin->check_create_datawriter = AllowWriter;
    plugin->check_create_topic = AllowTopic;
  }
  return result;
}

int finalize_access_control(void* context);
int finalize_access_control(void* context) {
  void* library = Library();
  Finalize* real = library != NULL ? (Finalize*)dlsym(library, "finalize_access_control") : NULL;
  return real != NULL ? real(context) : -1;
}
