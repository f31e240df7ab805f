/* The interface between Tandem's device process and a driver: a C interface, so that a driver can be built by any compiler, out
 * of this tree, and under a licence of its own. Guide: docs/devices.md. Example: docs/examples/device.
 *
 * A driver is a shared library NAME.so that exports one constant of the type TandemDriver, called `tandem_driver`. Only the program
 * tandem-device loads it, in a process of its own: a driver that crashes takes no simulation along.
 *
 * Units are SI. The device's frame V is right-handed: x points to the right of the person, y upwards, z towards the person. Quaternions
 * are x, y, z, w. A device reports where its handle is in V; tandem-device maps the handle into the scene.
 *
 * Threads: "main" is one thread that may wait, allocate and take locks. "loop" is the thread that runs at the device's rate, at real-time
 * priority: a function for it must not allocate, lock, wait or throw. "any" is every thread and a signal handler, at any time.
 */
#ifndef TANDEM_DEVICE_H
#define TANDEM_DEVICE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* tandem-device takes a driver of the same major number. A minor number counts additions: members at the end of structures. Whoever
 * fills a structure sets its struct_size, and whoever reads it reads no member beyond that. */
#define TANDEM_DEVICE_ABI_MAJOR 1u
#define TANDEM_DEVICE_ABI_MINOR 0u

/* What functions return. Below zero: it failed, and last_error() says why. */
enum {
  TANDEM_OK = 0,
  TANDEM_REPEATED = 1,      /* read(): nothing newer than last time */
  TANDEM_FAILED = -1,       /* this call; the next may go well */
  TANDEM_UNPLUGGED = -2,    /* until the device comes back */
  TANDEM_UNCALIBRATED = -3, /* until a person calibrates it */
  TANDEM_BROKEN = -4        /* for good: close it */
};

/* Bits of TandemDeviceState.valid. */
enum { TANDEM_HAS_POSE = 1u, TANDEM_HAS_VELOCITY = 2u };

/* Bits of TandemDeviceState.buttons. */
enum {
  TANDEM_BUTTON_CLUTCH = 1u, /* the handle moves alone, what it holds stays */
  TANDEM_BUTTON_STOP = 2u    /* emergency stop */
};

/* What read() says of the handle. */
typedef struct TandemDeviceState {
  uint32_t struct_size;
  uint32_t valid;            /* TANDEM_HAS_… */
  int64_t time_ns;           /* of the measurement, by the host's clock; 0: now */
  double position[3];        /* m, of the handle in V */
  double orientation[4];     /* x y z w, of the handle in V */
  double velocity[3];        /* m/s; without TANDEM_HAS_VELOCITY the host derives both */
  double angular_velocity[3]; /* rad/s */
  uint32_t buttons;          /* TANDEM_BUTTON_… */
  uint32_t reserved;
} TandemDeviceState;

/* What write() gives the motors: what is to act on the hand at the handle's origin, in V. The host has limited it. */
typedef struct TandemDeviceForce {
  uint32_t struct_size;
  uint32_t begun;   /* not 0: the user has begun; a script's clock runs from then on */
  double force[3];  /* N */
  double moment[3]; /* N m */
} TandemDeviceForce;

/* What a device can. A number that is 0 where "any" is written sets no limit. */
typedef struct TandemDeviceCapabilities {
  uint32_t struct_size;
  uint32_t freedoms_in;       /* degrees of freedom that it measures, 0 to 6 */
  uint32_t freedoms_out;      /* that its motors drive; 0: no force feedback */
  uint32_t asks;              /* not 0: a thread of the vendor's calls host->take(); write() only tells `begun` */
  uint32_t in_scene;          /* not 0: it reports poses in the scene's world frame, from `home` on, as scripts do */
  uint32_t moves_by_itself;   /* not 0: start() may move the handle (calibration) */
  double rate_hz;             /* of its own loop; 0: 1000 */
  double peak_force;          /* N that it gives for a moment; 0: it has no motors */
  double peak_moment;         /* N m */
  double continuous_force;    /* N that it gives for ever; 0: as peak */
  double continuous_moment;   /* N m; 0: as peak */
  double workspace_min[3];    /* m, of the handle in V; all 0: unknown */
  double workspace_max[3];
  double stiffness;           /* N/m that it renders without shaking; 0: any */
  double damping;             /* N s/m; 0: any */
  double rotation_stiffness;  /* N m/rad; 0: any */
  double rotation_damping;    /* N m s/rad; 0: any */
} TandemDeviceCapabilities;

/* One device that list() found, or one thing that is missing. Texts end with a zero byte. */
typedef struct TandemDeviceFound {
  uint32_t struct_size;
  uint32_t present;    /* not 0: the device is there and can be opened now */
  char name[64];       /* of the model, "omega.6" */
  char options[128];   /* that open this one rather than another of its kind; empty: none needed */
  char missing[192];   /* what there is not: a library, a service, a right; empty: nothing */
  char mend[320];      /* the one line that mends it: a command, or what to do; empty: nothing to mend */
} TandemDeviceFound;

/* What tandem-device gives a driver. It lives as long as the driver. */
typedef struct TandemDeviceHost {
  uint32_t struct_size;
  uint32_t abi_minor;
  void* context;                                        /* for the two below */
  void (*say)(void* context, const char* line);         /* main: one line for a person */
  void (*take)(void* context, TandemDeviceForce* force); /* the vendor's thread: what the motors may have now; never waits */
  int64_t (*now_ns)(void);                              /* any: monotonic clock */
} TandemDeviceHost;

typedef struct TandemDevice TandemDevice; /* the driver's own */

typedef struct TandemDeviceOpen {
  uint32_t struct_size;
  uint32_t reserved;
  const char* options;         /* what stands behind NAME: on the command line; never null */
  double home_position[3];     /* m, where the part stands that the hand is to hold, in the scene's world frame */
  double home_orientation[4];  /* x y z w */
} TandemDeviceOpen;

/* A driver. `name` is the file's name without .so: small letters, digits and '-'. Functions that are null are not there: extension()
 * alone may be null. */
typedef struct TandemDriver {
  uint32_t struct_size;
  uint32_t abi_major; /* TANDEM_DEVICE_ABI_MAJOR */
  uint32_t abi_minor; /* TANDEM_DEVICE_ABI_MINOR */
  uint32_t reserved;
  const char* name;
  const char* kind;    /* what it is, for a list, "haptic arm of 3D Systems (Touch, Phantom)" */
  const char* options; /* its options, for help, "device=NAME,calibrate=yes"; empty: none */

  /* main. First of all calls; touches no device. */
  int32_t (*init)(const TandemDeviceHost* host);
  /* main. Last of all calls. */
  void (*deinit)(void);
  /* main. Fills as many as there is room for with what is there and what is missing, and returns how many it filled. May take two
   * seconds. Opens no device and moves none. */
  int32_t (*list)(TandemDeviceFound* found, int32_t room);
  /* main. Opens the device that the options name, without force. May take seconds. */
  int32_t (*open)(const TandemDeviceOpen* how, TandemDevice** device);
  /* main. Ends all force and all threads of the device, and frees it. */
  void (*close)(TandemDevice* device);
  /* main, after open(). */
  int32_t (*capabilities)(TandemDevice* device, TandemDeviceCapabilities* can);
  /* main, once, after open(). read() and write() follow: all allocation ends here. */
  int32_t (*start)(TandemDevice* device);
  /* loop. Where the handle is. */
  int32_t (*read)(TandemDevice* device, TandemDeviceState* state);
  /* loop, after each read(). What the motors are to give. */
  int32_t (*write)(TandemDevice* device, const TandemDeviceForce* force);
  /* any. No force from now on until the next write(), whatever else hangs. */
  void (*stop)(TandemDevice* device);
  /* main. Why a call returned less than zero, in one line for a person: what happened, what to do. `device` is null where open()
   * failed. Returns TANDEM_OK where there is something to say. */
  int32_t (*last_error)(TandemDevice* device, char* text, uint32_t room);
  /* main. Further functions by name, for versions to come; null: none. */
  const void* (*extension)(const char* name);
} TandemDriver;

/* What the shared library defines:
 *   const TandemDriver tandem_driver = {sizeof(TandemDriver), TANDEM_DEVICE_ABI_MAJOR, TANDEM_DEVICE_ABI_MINOR, 0, "name", …}; */
extern __attribute__((visibility("default"))) const TandemDriver tandem_driver;

#ifdef __cplusplus
}
#endif

#endif
