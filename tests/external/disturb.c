/* Put before a program's libc: disks that are slow, and a clock that is wrong, by two numbers in the file DISTURB, which may
   change at any time: microseconds that each writing takes longer, and seconds that the clock is ahead. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static volatile int64_t none[2], *numbers = none;

__attribute__((constructor)) static void begin(void) {
    int file = open(getenv("DISTURB") ? getenv("DISTURB") : "", O_RDONLY | O_CLOEXEC);
    if (file < 0) return;
    void *shared = mmap(NULL, sizeof none, PROT_READ, MAP_SHARED, file, 0);
    if (shared != MAP_FAILED) numbers = shared;
    close(file);
}

int clock_gettime(clockid_t clock, struct timespec *time) {
    int failed = syscall(SYS_clock_gettime, clock, time);
    if (!failed && clock == CLOCK_REALTIME) time->tv_sec += numbers[1];
    return failed;
}

static void wait(void) {
    if (numbers[0]) usleep(numbers[0]);
}

static void wait_for_file(int file) {
    struct stat about;
    if (numbers[0] && !fstat(file, &about) && S_ISREG(about.st_mode)) wait();
}

#define REAL(name, ...) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))(__VA_ARGS__)

int fsync(int file) { wait(); return REAL(fsync, file); }
int fdatasync(int file) { wait(); return REAL(fdatasync, file); }
int rename(const char *from, const char *to) { wait(); return REAL(rename, from, to); }
ssize_t write(int file, const void *bytes, size_t count) { wait_for_file(file); return REAL(write, file, bytes, count); }
ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t at) { wait(); return REAL(pwrite64, file, bytes, count, at); }
