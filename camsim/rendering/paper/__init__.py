"""The paper's methods, kept by name: what people used before, and what the exact engines are measured against."""
