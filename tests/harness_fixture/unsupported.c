/* FMI 2.0 functions that an importer looks up and the lag does not offer: all answer Error (3). */
#define UNSUPPORTED(name) int name(void) { return 3; }
UNSUPPORTED(fmi2SetDebugLogging)
UNSUPPORTED(fmi2GetString)
UNSUPPORTED(fmi2SetString)
UNSUPPORTED(fmi2GetFMUstate) UNSUPPORTED(fmi2SetFMUstate) UNSUPPORTED(fmi2FreeFMUstate)
UNSUPPORTED(fmi2SerializedFMUstateSize) UNSUPPORTED(fmi2SerializeFMUstate)
UNSUPPORTED(fmi2DeSerializeFMUstate) UNSUPPORTED(fmi2GetDirectionalDerivative)
UNSUPPORTED(fmi2CancelStep) UNSUPPORTED(fmi2GetStatus)
UNSUPPORTED(fmi2GetIntegerStatus)
UNSUPPORTED(fmi2GetStringStatus)
