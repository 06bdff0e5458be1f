/* Wine 8 lacks bcryptprimitives.dll, which the checker's HashMap asks for random numbers.
 * The FMUs do not need it. */
#include <windows.h>

BOOLEAN WINAPI SystemFunction036(PVOID buffer, ULONG length);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE buffer, SIZE_T length)
{
    return SystemFunction036(buffer, (ULONG)length);
}
