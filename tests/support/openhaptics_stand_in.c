/* Stands in for OpenHaptics' HD library: moves a stylus, calls back, remembers what it is told.

   With OPENHAPTICS_STAND_IN it is held upright where that file says: x, y, z in mm and the buttons;
   the force that it is told is written behind them, N, and how often it has called. */
#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

typedef struct { unsigned code; int internal; unsigned device; } Error;
typedef unsigned (*Callback)(void *);

static Callback callback;
static pthread_t thread;
static volatile int running, in_frame;
static unsigned error_code;
int calls, frames_without_begin, force_enabled, disabled, fail_at = -1, refuse;
double forces[100000][3], max_force = 3.3;

static volatile double *held;

unsigned hdInitDevice(const char *name) {
    (void)name;
    const char *file = getenv("OPENHAPTICS_STAND_IN");
    if (file && !held) {
        int f = open(file, O_RDWR);
        held = mmap(0, 64, PROT_READ | PROT_WRITE, MAP_SHARED, f, 0);
        close(f);
    }
    if (refuse) error_code = 0x0301;
    return refuse ? 0xFFFFFFFFu : 7;
}
void hdDisableDevice(unsigned h) { disabled = (h == 7); }
void hdEnable(unsigned what) { if (what == 0x4000) force_enabled = 1; }
void hdDisable(unsigned what) { if (what == 0x4000) force_enabled = 0; }
void hdBeginFrame(unsigned h) { in_frame = (h == 7); }
void hdEndFrame(unsigned h) { (void)h; in_frame = 0; calls++; }
void hdGetIntegerv(unsigned what, int *out) {
    if (held) { *out = (int)held[3]; return; }
    if (what == 0x2000) *out = calls >= 50 ? 1 : 0;
}
void hdGetDoublev(unsigned what, double *out) {
    if (what == 0x2603) { *out = max_force; return; }
    if (what == 0x2602) { *out = 0.4; return; }
    if (what != 0x2052) return;
    if (!in_frame) frames_without_begin++;
    /* turned by a quarter about x (columns), and calls / 10 mm up */
    static const double m[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 5, 0, -3, 1};
    static const double upright[16] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
    if (held) {
        memcpy(out, upright, sizeof upright);
        for (int k = 0; k < 3; k++) out[12 + k] = held[k];
        return;
    }
    memcpy(out, m, sizeof m);
    out[13] = calls * 0.1;
}
void hdSetDoublev(unsigned what, const double *in) {
    if (held) {
        for (int k = 0; k < 3; k++) held[4 + k] = in[k];
        held[7] += 1;
        return;
    }
    if (what == 0x2700 && calls < 100000) memcpy(forces[calls], in, 3 * sizeof(double));
}
Error hdGetError(void) {
    Error e = {error_code, 0, 7};
    error_code = 0; /* the library keeps an error until it is asked for, and then no longer */
    if (fail_at >= 0 && calls > fail_at) e.code = 0x0302;
    return e;
}
static void *serve(void *unused) {
    (void)unused;
    /* held by a test, twice as seldom: a program beside it must get its turn */
    struct timespec pause = {0, held ? 2000000 : 1000000};
    while (running && callback && callback(0)) nanosleep(&pause, 0);
    return 0;
}
unsigned long hdScheduleAsynchronous(Callback c, void *data, unsigned short priority) {
    (void)data; (void)priority; callback = c; return 3;
}
void hdStartScheduler(void) { running = 1; pthread_create(&thread, 0, serve, 0); }
void hdStopScheduler(void) { running = 0; pthread_join(thread, 0); }
void hdUnschedule(unsigned long ticket) { if (ticket == 3) callback = 0; }
