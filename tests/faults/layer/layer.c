/* Library loaded before libc into the server under test. It watches the calls that change files of
 * the data directory, makes some of them fail, writes all of them to a trace, and moves the clock.
 *
 * Environment: BROOD_FAULT_DATA names the data directory, BROOD_FAULT_CONTROL a file that the test
 * shares with this library (`struct control`), BROOD_FAULT_TRACE a file for the trace; without it,
 * nothing is traced. `layer.rs` is the other side of both files.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum fault { NONE, WRITE_EIO, WRITE_FULL, WRITE_SHORT, SYNC_EIO, READ_EIO, RESIZE_EIO };

/* Written by the test, except for `calls` and `failed`. */
struct control {
    _Atomic uint64_t fault;  /* enum fault */
    _Atomic uint64_t first;  /* number of the first call that fails, counted from 1 */
    _Atomic uint64_t count;  /* number of calls that fail */
    _Atomic uint64_t calls;  /* calls of this kind so far */
    _Atomic uint64_t failed; /* calls that have failed */
    _Atomic int64_t seconds; /* added to the time of day */
};

enum record { WRITTEN, RESIZED, SYNCED, CREATED, RENAMED, REMOVED };

static struct control none;
static struct control *control = &none;
static char data[PATH_MAX];
static size_t data_length;
static int trace = -1;
static pthread_mutex_t order = PTHREAD_MUTEX_INITIALIZER;

/* The function of libc that this library covers. */
#define REAL(name)                                                   \
    ({                                                               \
        static __typeof__(&name) real;                               \
        if (!real) real = (__typeof__(real))dlsym(RTLD_NEXT, #name); \
        real;                                                        \
    })

__attribute__((constructor)) static void begin(void) {
    const char *folder = getenv("BROOD_FAULT_DATA");
    if (folder && realpath(folder, data)) data_length = strlen(data);
    const char *shared = getenv("BROOD_FAULT_CONTROL");
    int file = shared ? REAL(open)(shared, O_RDWR | O_CLOEXEC) : -1;
    if (file >= 0) {
        void *page = mmap(NULL, sizeof(struct control), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        if (page != MAP_FAILED) control = page;
        close(file);
    }
    const char *path = getenv("BROOD_FAULT_TRACE");
    if (path) trace = REAL(open)(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
}

/* True if the path is the data directory or in it. */
static int is_inside(const char *path) {
    return data_length && !strncmp(path, data, data_length) &&
           (path[data_length] == '/' || !path[data_length]);
}

/* Writes the path of a file of the data directory; false for other files and removed ones. */
static int path_of(int file, char *path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, PATH_MAX - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return is_inside(path) && !strstr(path, " (deleted)");
}

/* True if this call is to fail. */
static int fails(enum fault fault) {
    if (atomic_load(&control->fault) != fault) return 0;
    uint64_t call = atomic_fetch_add(&control->calls, 1) + 1, first = atomic_load(&control->first);
    int failing = call >= first && call - first < atomic_load(&control->count);
    if (failing) atomic_fetch_add(&control->failed, 1);
    return failing;
}

/* Appends a record: kind, offset, length of the path, length of the content, path, content. */
static void record(enum record kind, const char *path, uint64_t at, const void *bytes, size_t count) {
    if (trace < 0) return;
    uint64_t head[4] = {kind, at, strlen(path), count};
    struct iovec parts[3] = {{head, sizeof head}, {(void *)path, head[2]}, {(void *)bytes, count}};
    ssize_t written = REAL(writev)(trace, parts, 3);
    if (written != (ssize_t)(sizeof head + head[2] + count)) abort();
}

/* Result of a call that a fault replaces. */
#define FAIL(code) return errno = (code), -1

static ssize_t write_at(int file, const void *bytes, size_t count, off_t at, int positioned) {
    char path[PATH_MAX];
    if (!path_of(file, path))
        return positioned ? REAL(pwrite)(file, bytes, count, at) : REAL(write)(file, bytes, count);
    if (fails(WRITE_EIO)) FAIL(EIO);
    if (fails(WRITE_FULL)) FAIL(ENOSPC);
    if (count > 1 && fails(WRITE_SHORT)) count /= 2;
    pthread_mutex_lock(&order);
    if (!positioned) at = lseek(file, 0, SEEK_CUR);
    if (!positioned && (fcntl(file, F_GETFL) & O_APPEND)) at = lseek(file, 0, SEEK_END);
    ssize_t written =
        positioned ? REAL(pwrite)(file, bytes, count, at) : REAL(write)(file, bytes, count);
    int code = errno;
    if (written > 0) record(WRITTEN, path, at, bytes, written);
    pthread_mutex_unlock(&order);
    errno = code;
    return written;
}

ssize_t write(int file, const void *bytes, size_t count) {
    return write_at(file, bytes, count, 0, 0);
}
ssize_t pwrite(int file, const void *bytes, size_t count, off_t at) {
    return write_at(file, bytes, count, at, 1);
}
ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t at) {
    return write_at(file, bytes, count, at, 1);
}
/* May write less than all parts, like the call itself. */
ssize_t writev(int file, const struct iovec *parts, int count) {
    char path[PATH_MAX];
    if (!path_of(file, path) || count < 1) return REAL(writev)(file, parts, count);
    return write_at(file, parts[0].iov_base, parts[0].iov_len, 0, 0);
}

static ssize_t read_at(int file, void *bytes, size_t count, off_t at) {
    char path[PATH_MAX];
    if (atomic_load(&control->fault) == READ_EIO && path_of(file, path) && fails(READ_EIO)) FAIL(EIO);
    return REAL(pread)(file, bytes, count, at);
}
ssize_t pread(int file, void *bytes, size_t count, off_t at) { return read_at(file, bytes, count, at); }
ssize_t pread64(int file, void *bytes, size_t count, off64_t at) { return read_at(file, bytes, count, at); }

static int sync_file(int file, int data_only) {
    char path[PATH_MAX];
    if (!path_of(file, path)) return data_only ? REAL(fdatasync)(file) : REAL(fsync)(file);
    if (fails(SYNC_EIO)) FAIL(EIO);
    /* What the trace says is on the disk counts, so the disk itself need not be waited for. */
    int traced = trace >= 0;
    int result = traced ? 0 : data_only ? REAL(fdatasync)(file) : REAL(fsync)(file);
    pthread_mutex_lock(&order);
    if (!result) record(SYNCED, path, 0, "", 0);
    pthread_mutex_unlock(&order);
    return result;
}
int fsync(int file) { return sync_file(file, 0); }
int fdatasync(int file) { return sync_file(file, 1); }

static int resize(int file, off_t length) {
    char path[PATH_MAX];
    if (!path_of(file, path)) return REAL(ftruncate)(file, length);
    if (fails(RESIZE_EIO)) FAIL(EIO);
    pthread_mutex_lock(&order);
    int result = REAL(ftruncate)(file, length), code = errno;
    if (!result) record(RESIZED, path, length, "", 0);
    pthread_mutex_unlock(&order);
    errno = code;
    return result;
}
int ftruncate(int file, off_t length) { return resize(file, length); }
int ftruncate64(int file, off64_t length) { return resize(file, length); }

static int open_at(int folder, const char *path, int flags, mode_t mode) {
    if (!(flags & (O_CREAT | O_TRUNC)) || !is_inside(path)) return REAL(openat)(folder, path, flags, mode);
    pthread_mutex_lock(&order);
    int known = !access(path, F_OK), file = REAL(openat)(folder, path, flags, mode), code = errno;
    if (file >= 0 && !known) record(CREATED, path, 0, "", 0);
    else if (file >= 0 && (flags & O_TRUNC)) record(RESIZED, path, 0, "", 0);
    pthread_mutex_unlock(&order);
    errno = code;
    return file;
}
#define OPEN(name, ...)                                                \
    int name(__VA_ARGS__ const char *path, int flags, ...) {           \
        mode_t mode = 0;                                               \
        if (flags & (O_CREAT | __O_TMPFILE)) {                         \
            va_list rest;                                              \
            va_start(rest, flags);                                     \
            mode = va_arg(rest, mode_t);                               \
            va_end(rest);                                              \
        }                                                              \
        return open_at(FOLDER, path, flags, mode);                     \
    }
#define FOLDER AT_FDCWD
OPEN(open, )
OPEN(open64, )
#undef FOLDER
#define FOLDER folder
#define AND ,
OPEN(openat, int folder AND)
OPEN(openat64, int folder AND)

int rename(const char *from, const char *to) {
    pthread_mutex_lock(&order);
    int result = REAL(rename)(from, to), code = errno;
    if (!result && is_inside(to)) record(RENAMED, from, 0, to, strlen(to));
    pthread_mutex_unlock(&order);
    errno = code;
    return result;
}

int unlink(const char *path) {
    pthread_mutex_lock(&order);
    int result = REAL(unlink)(path), code = errno;
    if (!result && is_inside(path)) record(REMOVED, path, 0, "", 0);
    pthread_mutex_unlock(&order);
    errno = code;
    return result;
}

int clock_gettime(clockid_t clock, struct timespec *time) {
    int result = REAL(clock_gettime)(clock, time);
    if (!result && clock == CLOCK_REALTIME) time->tv_sec += atomic_load(&control->seconds);
    return result;
}
