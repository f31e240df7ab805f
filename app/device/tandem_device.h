/* The interface between Tandem's device process and a driver. It is a C interface, so a driver can be built by any compiler, outside
 * this tree, and under a licence of its own. Guide: docs/devices.md. Example: docs/examples/device.
 *
 * A driver is a shared library NAME.so that exports one constant of the type TandemDriver, called `tandem_driver`. Only the program
 * tandem-device loads it, in a process of its own. So a driver's crash does not end a simulation.
 *
 * Units are SI. The device's frame V is right-handed: x points to the right of the person, y upwards, z towards the person. Quaternions
 * are x, y, z, w. A device reports its handle's pose in V, and tandem-device maps the handle into the scene.
 *
 * Threads: "main" is one thread that may wait, allocate and take locks. "loop" is the thread that runs at the device's rate, at real-time
 * priority; a function for it must not allocate, lock, wait or throw. "any" is every thread and a signal handler, at any time.
 */
#ifndef TANDEM_DEVICE_H
#define TANDEM_DEVICE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* tandem-device accepts a driver of the same major number. A minor number counts additions, which are members at the end of structures.
 * The side that fills a structure sets its struct_size, and the side that reads it reads no member beyond that. */
#define TANDEM_DEVICE_ABI_MAJOR 1u
#define TANDEM_DEVICE_ABI_MINOR 0u

/* Results of functions. Below zero the function failed, and last_error() says why. */
enum {
  TANDEM_OK = 0,
  TANDEM_REPEATED = 1,      /* read(): no newer measurement */
  TANDEM_FAILED = -1,       /* this call failed; the next may succeed */
  TANDEM_UNPLUGGED = -2,    /* unplugged, until the device comes back */
  TANDEM_UNCALIBRATED = -3, /* not calibrated, until a person calibrates it */
  TANDEM_BROKEN = -4        /* broken for good: close it */
};

/* Bits of TandemDeviceState.valid. */
enum { TANDEM_HAS_POSE = 1u, TANDEM_HAS_VELOCITY = 2u };

/* Bits of TandemDeviceState.buttons. */
enum {
  TANDEM_BUTTON_CLUTCH = 1u, /* the handle moves alone, and the part that it holds stays */
  TANDEM_BUTTON_STOP = 2u    /* emergency stop */
};

/* The state of the handle, from read(). */
typedef struct TandemDeviceState {
  uint32_t struct_size;
  uint32_t valid;            /* TANDEM_HAS_… */
  int64_t time_ns;           /* time of the measurement, by the host's clock; 0: now */
  double position[3];        /* m; handle in V */
  double orientation[4];     /* x y z w; handle in V */
  double velocity[3];        /* m/s; without TANDEM_HAS_VELOCITY the host derives both */
  double angular_velocity[3]; /* rad/s */
  uint32_t buttons;          /* TANDEM_BUTTON_… */
  uint32_t reserved;
} TandemDeviceState;

/* The wrench for the motors, from write(): it acts on the hand at the handle's origin, in V. The host has limited it. */
typedef struct TandemDeviceForce {
  uint32_t struct_size;
  uint32_t begun;   /* not 0: the user has begun, and a script's clock runs */
  double force[3];  /* N */
  double moment[3]; /* N m */
} TandemDeviceForce;

/* The capabilities of a device. Where "0: any" is written, 0 sets no limit. */
typedef struct TandemDeviceCapabilities {
  uint32_t struct_size;
  uint32_t freedoms_in;       /* degrees of freedom that the device measures, 0 to 6 */
  uint32_t freedoms_out;      /* degrees of freedom that the motors drive; 0: no force feedback */
  uint32_t asks;              /* not 0: a thread of the vendor calls host->take(), and write() only reports `begun` */
  uint32_t in_scene;          /* not 0: the device reports poses in the scene's world frame, beginning at `home`, as scripts do */
  uint32_t moves_by_itself;   /* not 0: start() may move the handle (calibration) */
  double rate_hz;             /* rate of the device's own loop; 0: 1000 */
  double peak_force;          /* N that the device gives for a moment; 0: no motors */
  double peak_moment;         /* N m */
  double continuous_force;    /* N that the device gives without end; 0: as peak */
  double continuous_moment;   /* N m; 0: as peak */
  double workspace_min[3];    /* m, handle in V; all 0: unknown */
  double workspace_max[3];
  double stiffness;           /* N/m that the device renders stably; 0: any */
  double damping;             /* N s/m; 0: any */
  double rotation_stiffness;  /* N m/rad; 0: any */
  double rotation_damping;    /* N m s/rad; 0: any */
} TandemDeviceCapabilities;

/* A device that list() found, or a thing that is missing. Texts end with a zero byte. */
typedef struct TandemDeviceFound {
  uint32_t struct_size;
  uint32_t present;    /* not 0: the device is there and can be opened */
  char name[64];       /* model's name, "omega.6" */
  char options[128];   /* options that open this device and no other of its kind; empty: none needed */
  char missing[192];   /* missing thing: a library, a service, a right; empty: nothing */
  char mend[320];      /* line that mends it: a command, or what to do; empty: nothing to mend */
} TandemDeviceFound;

/* The functions that tandem-device gives a driver. The structure lives as long as the driver. */
typedef struct TandemDeviceHost {
  uint32_t struct_size;
  uint32_t abi_minor;
  void* context;                                        /* argument of the next two */
  void (*say)(void* context, const char* line);         /* main: shows a line to a person */
  void (*take)(void* context, TandemDeviceForce* force); /* the vendor's thread: gets the wrench for the motors; never waits */
  int64_t (*now_ns)(void);                              /* any: returns the monotonic clock */
} TandemDeviceHost;

typedef struct TandemDevice TandemDevice; /* defined by the driver */

typedef struct TandemDeviceOpen {
  uint32_t struct_size;
  uint32_t reserved;
  const char* options;         /* text behind NAME: on the command line; never null */
  double home_position[3];     /* m; place, in the scene's world frame, of the part that the hand is to hold */
  double home_orientation[4];  /* x y z w */
} TandemDeviceOpen;

/* A driver. `name` is the file's name without .so: small letters, digits and '-'. A null function does not exist; only extension() may
 * be null. */
typedef struct TandemDriver {
  uint32_t struct_size;
  uint32_t abi_major; /* TANDEM_DEVICE_ABI_MAJOR */
  uint32_t abi_minor; /* TANDEM_DEVICE_ABI_MINOR */
  uint32_t reserved;
  const char* name;
  const char* kind;    /* kind of device, for a list, "haptic arm of 3D Systems (Touch, Phantom)" */
  const char* options; /* options, for help, "device=NAME,calibrate=yes"; empty: none */

  /* main. Called first; touches no device. */
  int32_t (*init)(const TandemDeviceHost* host);
  /* main. Called last. */
  void (*deinit)(void);
  /* main. Fills in up to `room` entries with devices that are there and things that are missing, and returns their number. May take two
   * seconds. Opens no device and moves none. */
  int32_t (*list)(TandemDeviceFound* found, int32_t room);
  /* main. Opens the device that the options name, without force. May take seconds. */
  int32_t (*open)(const TandemDeviceOpen* how, TandemDevice** device);
  /* main. Ends all force and all threads of the device, and frees it. */
  void (*close)(TandemDevice* device);
  /* main, after open(). Reports the capabilities. */
  int32_t (*capabilities)(TandemDevice* device, TandemDeviceCapabilities* can);
  /* main, once, after open(). Starts the device. All allocation ends here, since read() and write() follow. */
  int32_t (*start)(TandemDevice* device);
  /* loop. Reports the handle's state. */
  int32_t (*read)(TandemDevice* device, TandemDeviceState* state);
  /* loop, after each read(). Sets the wrench of the motors. */
  int32_t (*write)(TandemDevice* device, const TandemDeviceForce* force);
  /* any. Ends all force until the next write(), whatever else hangs. */
  void (*stop)(TandemDevice* device);
  /* main. Says in one line for a person why a call returned less than zero: what happened, and what to do. `device` is null where open()
   * failed. Returns TANDEM_OK where there is something to say. */
  int32_t (*last_error)(TandemDevice* device, char* text, uint32_t room);
  /* main. Returns further functions by name, for later versions; null: none. */
  const void* (*extension)(const char* name);
} TandemDriver;

/* The shared library defines:
 *   const TandemDriver tandem_driver = {sizeof(TandemDriver), TANDEM_DEVICE_ABI_MAJOR, TANDEM_DEVICE_ABI_MINOR, 0, "name", …}; */
extern __attribute__((visibility("default"))) const TandemDriver tandem_driver;

#ifdef __cplusplus
}
#endif

#endif
