/* Loads a library as often as told, asks it for an instance, which it refuses, and unloads it:
 * an importer that opens FMUs all day. */
#include <stdio.h>
#include <stdlib.h>
#include <windows.h>

typedef void *(*Instantiate)(const char *, int, const char *, const char *, const void *, int, int);

int main(int count, char **words)
{
    const void *callbacks[5] = {NULL};
    int loads = count > 2 ? atoi(words[2]) : 0;
    for (int i = 1; i <= loads; i++) {
        HMODULE library = LoadLibraryA(words[1]);
        Instantiate instantiate =
            library ? (Instantiate)(void *)GetProcAddress(library, "fmi2Instantiate") : NULL;
        if (!instantiate || instantiate("i", 1, "no guid", "", callbacks, 0, 0)) {
            fprintf(stderr, "load %d of %s failed\n", i, words[1]);
            return 1;
        }
        FreeLibrary(library);
    }
    printf("      %d loads\n", loads);
    return loads > 0 ? 0 : 2;
}
