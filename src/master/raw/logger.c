/* fmi2CallbackLogger: makes the text of a message and hands it to `cosim_log` in log.rs. */
#include <stdarg.h>
#include <stdio.h>

enum { LONGEST = 4000 }; /* bytes of a message that are kept, as in dct-harness */

void cosim_log(void *log, int status, const char *category, const char *text);

void cosim_logger(void *log, const char *instance, int status, const char *category,
                  const char *message, ...) {
    char text[LONGEST + 1] = "";
    (void)instance;
    if (message) {
        va_list more;
        va_start(more, message);
        vsnprintf(text, sizeof text, message, more);
        va_end(more);
    }
    cosim_log(log, status, category ? category : "", text);
}
