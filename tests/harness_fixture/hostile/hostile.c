/* The lag, but from t = 0.1 s on it misbehaves as its integer parameter `mode` says. */
#define _GNU_SOURCE
#include "fmi2Functions.h"
#undef fmi2DoStep
#undef fmi2Terminate
#define fmi2DoStep lag_step
#define fmi2Terminate lag_terminate
#undef _POSIX_C_SOURCE
#include "../lag.c"
#undef fmi2DoStep
#undef fmi2Terminate
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
enum { GOOD, CRASH, HANG, EXIT, FORK, FLOOD, CHDIR, PRINT, MEMORY, DAEMON, ABORT, GARBAGE, CLOSE,
    IGNORE_TERM, HANG_AT_END, REFUSE };

static void log_much(Lag *m) {
    for (int k = 0; k < 20000; k++)
        m->cb->logger(m->cb->componentEnvironment, "lag", fmi2OK, "flood", "message");
}

static void eat(void) {
    for (;;) {
        char *block = malloc(1 << 24);
        if (!block) abort();
        memset(block, 1, 1 << 24);
    }
}

static void start_daemon(void) {
    if (fork() == 0) {
        setsid();
        if (fork() == 0) { sleep(100); }
        _exit(0);
    }
    sleep(1);
}

static void misbehave(Lag *m) {
    char junk[64];
    memset(junk, 'J', sizeof junk);
    switch (m->n[0]) {
    case CRASH: raise(SIGSEGV); break;
    case HANG: is_slow(); for (;;) pause();
    case EXIT: exit(7);
    case FORK: if (fork() == 0) return; break;
    case FLOOD: log_much(m); break;
    case CHDIR: if (chdir("/") != 0) abort(); break;
    case PRINT: for (int k = 0; k < 100000; k++) puts("the FMU prints a line on standard output"); break;
    case MEMORY: eat(); break;
    case DAEMON: start_daemon(); break;
    case ABORT: fputs("assertion failed: gear > 0\n", stderr); abort();
    case GARBAGE: for (int fd = 0; fd < 32; fd++) if (write(fd, junk, sizeof junk) < 0) continue; break;
    case CLOSE: for (int fd = 0; fd < 32; fd++) close(fd); for (;;) pause();
    case IGNORE_TERM: signal(SIGTERM, SIG_IGN); signal(SIGINT, SIG_IGN); for (;;) pause();
    default: break;
    }
}

/* It tells of every call when it is asked to log, and of its errors only then. */
static fmi2Status refused(Lag *m) {
    const fmi2CallbackFunctions *cb = m->cb;
    if (!m->log) return fmi2Error;
    log_much(m);
    cb->logger(cb->componentEnvironment, "lag", fmi2Error, "logStatusError", "no gear %d", 9);
    return fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, double t, double h, fmi2Boolean f) {
    if (t >= 0.0995) misbehave(c);
    if (t >= 0.0995 && ((Lag *)c)->n[0] == REFUSE) return refused(c);
    return lag_step(c, t, h, f);
}
fmi2Status fmi2Terminate(fmi2Component c) {
    if (((Lag *)c)->n[0] == HANG_AT_END) for (;;) pause();
    return fmi2OK;
}
